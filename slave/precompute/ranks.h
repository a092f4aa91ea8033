// The processes of one MPI run.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <mpi.h>

namespace palpate {

// An error that every rank knows of: all end, the first one prints it.
class RanksError : public std::runtime_error {
 public:
  RanksError(int exit_code, const std::string& what)
      : std::runtime_error(what), exit_code_(exit_code) {}
  [[nodiscard]] int exit_code() const { return exit_code_; }

 private:
  int exit_code_;
};

// MPI_COMM_WORLD. All but the cheap accessors is called by every rank at the same time.
class Ranks {
 public:
  Ranks();
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] bool first() const { return rank_ == 0; }
  [[nodiscard]] int fortran_communicator() const { return MPI_Comm_c2f(MPI_COMM_WORLD); }

  // Runs work that no rank waits in for another. If it throws on any rank, throws RanksError with
  // the message of the lowest one on all of them.
  void Together(const std::function<void()>& work) const;
  // The same on the first rank only.
  void OnFirst(const std::function<void()>& work) const {
    Together([&] {
      if (first()) work();
    });
  }

  [[nodiscard]] bool Any(bool here) const;
  [[nodiscard]] std::vector<double> Gather(double here) const;  // on the first rank
  // The numbers of the first rank.
  void Broadcast(int* value) const;
  void Broadcast(std::vector<double>* values) const;
  // Throws RanksError unless `value` is the same everywhere; `what` must be so.
  void RequireSame(std::uint64_t value, const std::string& what) const;
  // The largest of all ranks, number by number.
  void Largest(std::span<int> values) const;

 private:
  int rank_ = 0, size_ = 1;
};

// Ends all ranks at once, whatever they do. `exit_code` is that of mpirun.
[[noreturn]] void EndAllRanks(int exit_code);

}  // namespace palpate
