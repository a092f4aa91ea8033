// A few threads that share repeated loops.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

namespace palpate::fem {

// Calls `work(first, last)` on pieces of [0, count) until all are done. The computation for an
// index must not depend on other indices, so that the result does not depend on the number of
// threads.
class WorkerTeam {
 public:
  // `threads` >= 1, the calling one included.
  explicit WorkerTeam(int threads);
  ~WorkerTeam();
  WorkerTeam(const WorkerTeam&) = delete;
  WorkerTeam& operator=(const WorkerTeam&) = delete;

  // Returns when all is done. Allocation-free; one caller at a time.
  template <typename Work>
  void For(int count, const Work& work) noexcept {
    const auto call = [](const void* w, int first, int last) {
      (*static_cast<const Work*>(w))(first, last);
    };
    Run(count, call, &work);
  }

 private:
  using Call = void (*)(const void*, int, int);

  void Run(int count, Call call, const void* work) noexcept;
  void Serve(int worker) noexcept;
  void DoShare(int worker) const noexcept;

  std::atomic<unsigned> round_{0};  // rises to start work
  std::atomic<int> busy_{0};        // workers that have not finished
  bool stopping_ = false;           // written before round_ rises, as the three below
  int count_ = 0;
  Call call_ = nullptr;
  const void* work_ = nullptr;
  std::vector<std::thread> threads_;
};

}  // namespace palpate::fem
