// The files of the page, which are part of the program. Nothing is read from disk or network.
#pragma once

#include <span>
#include <string_view>

namespace palpate {

struct PageFile {
  std::string_view path;  // "/index.html"
  std::string_view type;  // "text/html; charset=utf-8"
  std::string_view bytes;
};

// All files. Those of npm (three.js, uPlot) are included only if they existed at build time.
std::span<const PageFile> PageFiles();
// The file of a request; "/" is the page. Null: there is none.
const PageFile* FindPageFile(std::string_view target);

}  // namespace palpate
