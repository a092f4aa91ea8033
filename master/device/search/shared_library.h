// A vendor's library, loaded at run time from the user's installation. Nothing here throws: if
// loading fails, the caller gets the reason as text.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate {

// LibrarySearch lists the names and folders in which a library is searched.
struct LibrarySearch {
  std::vector<std::string> names;              // such as libdhd.so.3; the first one found is taken
  std::vector<std::filesystem::path> folders;  // before the places of the system's loader
  bool global = false;                         // its companions need its symbols
};
// `folders` for people: `libHD.so, libHD.so.3.4 in /opt/lib and where the system looks`.
std::string InWords(const LibrarySearch& search);

// A loaded library stays loaded: threads of a vendor may still run in it.
class SharedLibrary {
 public:
  // Also sets the number format of the process to that of C, which vendors' parsers expect.
  explicit SharedLibrary(const LibrarySearch& search);

  // Sets `function` to the symbol `name`. A missing one becomes null and part of `problem`.
  template <class Function>
  void Bind(const char* name, Function** function) {
    *function = reinterpret_cast<Function*>(FindSymbol(name, true));
  }
  // Loads a function that the driver can do without: null if the library has none.
  template <class Function>
  void BindOptional(const char* name, Function** function) {
    *function = reinterpret_cast<Function*>(FindSymbol(name, false));
  }

  [[nodiscard]] const std::string& file() const { return file_; }  // empty: not loaded
  // Returns why it cannot be used: the loader's words for each file, or the missing symbols. Empty:
  // it can.
  [[nodiscard]] std::string problem() const;

 private:
  bool Load(const std::string& file);
  void* FindSymbol(const char* name, bool required);

  void* handle_ = nullptr;
  int flags_;
  std::string file_;
  std::vector<std::string> failures_;  // of the loader
  std::vector<std::string> missing_;   // symbols
};

// Value of the environment variable `name` with `tail` appended; empty if it is not set.
std::vector<std::filesystem::path> FolderOf(const char* name, const std::string& tail);

}  // namespace palpate
