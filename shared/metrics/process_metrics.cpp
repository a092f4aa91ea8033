#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include <sys/resource.h>
#include <unistd.h>

#include "shared/metrics/metrics_page.h"

namespace palpate {
namespace {

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

void AddMemory(Metrics* metrics) {
  double pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  if (resident <= 0) return;
  metrics->push_back(Gauge("process_resident_memory_bytes", "Memory in use.",
                           resident * static_cast<double>(sysconf(_SC_PAGESIZE))));
}

// Adds the number of entries of a system folder.
void AddCount(const char* folder, const char* name, const char* help, Metrics* metrics) {
  std::error_code error;
  const std::filesystem::directory_iterator entries(folder, error);
  if (error) return;
  const auto count = std::distance(begin(entries), end(entries));
  metrics->push_back(Gauge(name, help, static_cast<double>(count)));
}

}  // namespace

Metrics MetricsOfThisProcess() {
  Metrics metrics;
  AddMemory(&metrics);
  rusage used{};
  if (getrusage(RUSAGE_SELF, &used) == 0) {
    metrics.push_back(Counter("process_cpu_seconds_total", "Processor time used.",
                              Seconds(used.ru_utime) + Seconds(used.ru_stime)));
  }
  AddCount("/proc/self/fd", "process_open_fds", "Open file descriptors.", &metrics);
  AddCount("/proc/self/task", "process_threads", "Number of threads.", &metrics);
  return metrics;
}

}  // namespace palpate
