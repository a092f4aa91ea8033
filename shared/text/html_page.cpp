#include "shared/text/html_page.h"

#include "shared/text/svg.h"

namespace palpate {
namespace {

constexpr std::string_view kStyle = R"(
body { font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; max-width: 1360px; margin: 2em auto;
       padding: 0 1em; color: #1d2430; background: #ffffff; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin-top: 1.6em; }
table { border-collapse: collapse; } th, td { padding: 3px 14px 3px 0; text-align: right; }
th { border-bottom: 1px solid #8a94a6; color: #5b6576; font-weight: 600; }
th:first-child, td:first-child { text-align: left; }
@media (prefers-color-scheme: dark) {
body { color: #e8ecf2; background: #14181f; } th { color: #a9b3c2; } }
)";

}  // namespace

HtmlPage::HtmlPage(std::string_view title) {
  body_ = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><title>";
  body_.append(XmlEscaped(title)).append("</title><style>").append(kStyle);
  body_.append("</style></head><body>\n<h1>").append(XmlEscaped(title)).append("</h1>\n");
}

void HtmlPage::Heading(std::string_view words) {
  body_.append("<h2>").append(XmlEscaped(words)).append("</h2>\n");
}

void HtmlPage::Paragraph(std::string_view words) {
  body_.append("<p>").append(XmlEscaped(words)).append("</p>\n");
}

void HtmlPage::Table(const std::vector<std::string>& head,
                     const std::vector<std::vector<std::string>>& rows) {
  const auto row = [&](const std::vector<std::string>& cells, std::string_view element) {
    body_ += "<tr>";
    for (const std::string& cell : cells) {
      body_.append("<").append(element).append(">").append(XmlEscaped(cell));
      body_.append("</").append(element).append(">");
    }
    body_ += "</tr>\n";
  };
  body_ += "<table>\n";
  row(head, "th");
  for (const auto& cells : rows) row(cells, "td");
  body_ += "</table>\n";
}

void HtmlPage::Drawing(std::string_view svg) {
  body_.append(svg).append("\n");
}

}  // namespace palpate
