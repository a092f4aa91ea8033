#include "master/station/server/page_files.h"

#include <algorithm>

namespace palpate {

// A question mark ends the name of the file.
const PageFile* FindPageFile(std::string_view target) {
  std::string_view path = target.substr(0, target.find('?'));
  if (path == "/") path = "/index.html";
  const auto files = PageFiles();
  const auto found = std::ranges::find(files, path, &PageFile::path);
  return found == files.end() ? nullptr : &*found;
}

}  // namespace palpate
