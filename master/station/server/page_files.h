// The page's own files, inside the program: nothing is read from the disk and nothing from
// elsewhere while it runs.
#pragma once

#include <span>
#include <string_view>

namespace palpate {

struct PageFile {
  std::string_view path;  // "/index.html"
  std::string_view type;  // "text/html; charset=utf-8"
  std::string_view bytes;
};

// All of them; what npm brings (three.js, uPlot) only where it was there when this was built.
std::span<const PageFile> PageFiles();
// Of what is asked for, "/" being the page itself. Null: there is none.
const PageFile* FindPageFile(std::string_view target);

}  // namespace palpate
