#include "slave/precompute/ranks.h"

#include <cstdlib>
#include <exception>

#include "slave/commands/program.h"
#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

struct Failure {
  int exit_code = 0;  // 0: none
  std::string what;
};

Failure Try(const std::function<void()>& work) {
  try {
    work();
  } catch (const SceneError& error) {
    return {kUnusable, error.what()};
  } catch (const std::invalid_argument& error) {
    return {kUnusable, error.what()};
  } catch (const std::bad_alloc&) {
    return {kFailed, "out of memory"};
  } catch (const std::exception& error) {
    return {kFailed, error.what()};
  }
  return {};
}

}  // namespace

Ranks::Ranks() {
  int level = 0;  // other threads do not call MPI
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
}

Ranks::~Ranks() {
  MPI_Finalize();
}

void Ranks::Together(const std::function<void()>& work) const {
  Failure failure = Try(work);
  const int here = failure.exit_code == 0 ? size_ : rank_;
  int failed = size_;
  MPI_Allreduce(&here, &failed, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  if (failed == size_) return;
  int length = static_cast<int>(failure.what.size());
  MPI_Bcast(&failure.exit_code, 1, MPI_INT, failed, MPI_COMM_WORLD);
  MPI_Bcast(&length, 1, MPI_INT, failed, MPI_COMM_WORLD);
  failure.what.resize(static_cast<std::size_t>(length));
  MPI_Bcast(failure.what.data(), length, MPI_CHAR, failed, MPI_COMM_WORLD);
  throw RanksError(failure.exit_code, failed == 0
                                          ? failure.what
                                          : "rank " + std::to_string(failed) + ": " + failure.what);
}

bool Ranks::Any(bool here) const {
  const int mine = here ? 1 : 0;
  int any = 0;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return any != 0;
}

std::vector<double> Ranks::Gather(double here) const {
  std::vector<double> all(first() ? static_cast<std::size_t>(size_) : 0);
  MPI_Gather(&here, 1, MPI_DOUBLE, all.data(), 1, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  return all;
}

void Ranks::Broadcast(int* value) const {
  MPI_Bcast(value, 1, MPI_INT, 0, MPI_COMM_WORLD);
}

void Ranks::Broadcast(std::vector<double>* values) const {
  int count = static_cast<int>(values->size());
  Broadcast(&count);
  values->resize(static_cast<std::size_t>(count));
  MPI_Bcast(values->data(), count, MPI_DOUBLE, 0, MPI_COMM_WORLD);
}

void Ranks::RequireSame(std::uint64_t value, const std::string& what) const {
  std::uint64_t least = 0, most = 0;
  MPI_Allreduce(&value, &least, 1, MPI_UINT64_T, MPI_MIN, MPI_COMM_WORLD);
  MPI_Allreduce(&value, &most, 1, MPI_UINT64_T, MPI_MAX, MPI_COMM_WORLD);
  if (least == most) return;
  throw RanksError(kUnusable, "the ranks read different inputs: accepted is " + what +
                                  " that is the same on every machine");
}

void Ranks::Largest(std::span<int> values) const {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_INT, MPI_MAX,
                MPI_COMM_WORLD);
}

void EndAllRanks(int exit_code) {
  MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::abort();
}

}  // namespace palpate
