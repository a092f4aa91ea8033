#include "slave/program/run_program.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "slave/program/progress.h"

namespace palpate {
namespace {

constexpr std::size_t kMaxOutput = 4000;
constexpr std::chrono::milliseconds kLook{5};

// Settings of posix_spawn: folder, input, output, and default signals.
class SpawnSettings {
 public:
  SpawnSettings(const std::filesystem::path& folder, int output) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawnattr_init(&attributes_);
    posix_spawn_file_actions_addchdir_np(&actions_, folder.c_str());
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, STDERR_FILENO, "log",
                                     O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW, 0600);
    posix_spawn_file_actions_adddup2(&actions_, output < 0 ? STDERR_FILENO : output, STDOUT_FILENO);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setpgroup(&attributes_, 0);  // one of its own, to be killed with its children
    posix_spawnattr_setflags(
        &attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  [[nodiscard]] const posix_spawn_file_actions_t* actions() const { return &actions_; }
  [[nodiscard]] const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

std::vector<char*> Pointers(std::vector<std::string>* texts) {
  std::vector<char*> pointers;
  for (std::string& text : *texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

// Returns the environment of this process with the C number format.
std::vector<std::string> Environment() {
  std::vector<std::string> variables{"LC_ALL=C"};
  for (char** variable = environ; *variable != nullptr; ++variable) {
    if (!std::string_view(*variable).starts_with("LC_ALL=")) variables.emplace_back(*variable);
  }
  return variables;
}

pid_t Start(const std::filesystem::path& program, const std::vector<std::string>& arguments,
            const std::filesystem::path& folder, int output) {
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<std::string> environment = Environment();
  const SpawnSettings settings(folder, output);
  pid_t pid = 0;
  const int error = posix_spawn(&pid, program.c_str(), settings.actions(), settings.attributes(),
                                Pointers(&words).data(), Pointers(&environment).data());
  if (error != 0) {
    throw std::runtime_error(program.string() + " cannot be started: " + std::strerror(error));
  }
  return pid;
}

std::string LastOf(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (!error && size > kMaxOutput) stream.seekg(static_cast<std::streamoff>(size - kMaxOutput));
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

RunningProgram::RunningProgram(const std::filesystem::path& program,
                               const std::vector<std::string>& arguments,
                               std::filesystem::path folder, int output)
    : folder_(std::move(folder)), pid_(Start(program, arguments, folder_, output)) {}

RunningProgram::~RunningProgram() {
  if (ended_) return;
  Kill();
  Wait();
}

std::optional<ProgramEnd> RunningProgram::Ended() {
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return std::nullopt;
  return End(status);
}

ProgramEnd RunningProgram::Wait() {
  int status = 0;
  while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  return End(status);
}

void RunningProgram::Kill() const {
  kill(-pid_, SIGKILL);
}

ProgramEnd RunningProgram::End(int status) {
  ended_ = true;
  return {WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status),
          LastOf(folder_ / "log")};
}

std::optional<std::filesystem::path> FindProgram(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (folder.empty()) continue;  // the working directory: not searched
    const std::filesystem::path file = std::filesystem::path(folder) / name;
    std::error_code error;
    if (std::filesystem::is_regular_file(file, error) && access(file.c_str(), X_OK) == 0) {
      return std::filesystem::absolute(file, error);
    }
  }
  return std::nullopt;
}

ProgramEnd RunProgram(const std::filesystem::path& program,
                      const std::vector<std::string>& arguments,
                      const std::filesystem::path& folder, std::chrono::milliseconds timeout,
                      const std::stop_token& stop) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  RunningProgram running(program, arguments, folder, -1);
  for (;;) {
    if (auto end = running.Ended()) return *std::move(end);
    if (stop.stop_requested()) throw Interrupted();
    if (std::chrono::steady_clock::now() > deadline) {
      throw std::runtime_error(program.filename().string() + " took longer than " +
                               std::to_string(timeout.count()) + " ms and was stopped");
    }
    std::this_thread::sleep_for(kLook);
  }
}

}  // namespace palpate
