#include "master/device/search/shared_library.h"

#include <clocale>
#include <cstdlib>
#include <string_view>

#include <dlfcn.h>
#include <link.h>

namespace palpate {
namespace {

std::string Joined(const std::vector<std::string>& words, std::string_view between) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : std::string(between)) + word;
  return all;
}

}  // namespace

std::string InWords(const LibrarySearch& search) {
  std::vector<std::string> places;
  for (const auto& folder : search.folders) places.push_back(folder.string());
  places.emplace_back("the folders of the system's loader");
  return Joined(search.names, ", ") + " in " + Joined(places, ", ");
}

SharedLibrary::SharedLibrary(const LibrarySearch& search)
    : flags_(RTLD_LAZY | (search.global ? RTLD_GLOBAL : RTLD_LOCAL)) {
  std::setlocale(LC_NUMERIC, "C");
  for (const auto& folder : search.folders) {
    for (const std::string& name : search.names) {
      std::error_code error;
      const auto file = folder / name;
      if (std::filesystem::exists(file, error) && Load(file.string())) return;
    }
  }
  for (const std::string& name : search.names) {
    if (Load(name)) return;
  }
}

bool SharedLibrary::Load(const std::string& file) {
  handle_ = dlopen(file.c_str(), flags_);
  if (handle_ == nullptr) {
    const char* why = dlerror();
    failures_.emplace_back(why != nullptr ? why : file + ": cannot be loaded");
    return false;
  }
  const link_map* map = nullptr;
  const bool is_known = dlinfo(handle_, RTLD_DI_LINKMAP, &map) == 0 && map->l_name != nullptr;
  file_ = is_known ? map->l_name : file;
  return true;
}

void* SharedLibrary::FindSymbol(const char* name, bool required) {
  void* symbol = handle_ == nullptr ? nullptr : dlsym(handle_, name);
  if (symbol == nullptr && required) missing_.emplace_back(name);
  return symbol;
}

std::string SharedLibrary::problem() const {
  if (handle_ == nullptr) return Joined(failures_, "; ");
  if (missing_.empty()) return {};
  return file_ + " has no " + Joined(missing_, ", ");
}

std::vector<std::filesystem::path> FolderOf(const char* name, const std::string& tail) {
  const char* value = std::getenv(name);
  if (value == nullptr || *value == '\0') return {};
  return {std::filesystem::path(value) / tail};
}

}  // namespace palpate
