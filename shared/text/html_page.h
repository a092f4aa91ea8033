// A report that opens in any browser and is one file: drawings are inside.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

class HtmlPage {
 public:
  explicit HtmlPage(std::string_view title);

  // All text is escaped.
  void Heading(std::string_view words);
  void Paragraph(std::string_view words);
  // `align` left; numbers are aligned right.
  void Table(const std::vector<std::string>& head,
             const std::vector<std::vector<std::string>>& rows);
  // An SVG document as it is.
  void Drawing(std::string_view svg);

  [[nodiscard]] std::string Document() const { return body_ + "</body></html>\n"; }

 private:
  std::string body_;
};

}  // namespace palpate
