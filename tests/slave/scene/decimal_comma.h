// Sets a locale with decimal commas during its lifetime: always for C++ streams, for the C library
// if such a locale is installed.
#pragma once

#include <clocale>
#include <locale>

namespace palpate {

class DecimalCommaLocale {
 public:
  DecimalCommaLocale() : before_(std::locale::global({std::locale(), new Comma})) {
    for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "fr_FR"}) {
      if (std::setlocale(LC_NUMERIC, name) != nullptr) break;
    }
  }
  ~DecimalCommaLocale() {
    std::locale::global(before_);
    std::setlocale(LC_NUMERIC, "C");
  }
  DecimalCommaLocale(const DecimalCommaLocale&) = delete;
  DecimalCommaLocale& operator=(const DecimalCommaLocale&) = delete;

 private:
  struct Comma : std::numpunct<char> {
    [[nodiscard]] char do_decimal_point() const override { return ','; }
  };
  std::locale before_;
};

}  // namespace palpate
