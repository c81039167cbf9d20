#include "isopach/report/draw/pen.hpp"

namespace isopach {

std::string Pen::fitted(const std::string& text, const Font& font, double width) {
  if (text_width(text, font) <= width) return text;
  const auto boundary = [&](std::size_t i) {  // never inside a UTF-8 sequence
    while (i < text.size() && (static_cast<unsigned char>(text[i]) & 0xC0u) == 0x80u) ++i;
    return i;
  };
  for (std::size_t keep = text.size() - 1; keep > 1; --keep) {
    const std::string cut = text.substr(0, boundary(keep / 2)) + "…" + text.substr(boundary(text.size() - keep / 2));
    if (text_width(cut, font) <= width) return cut;
  }
  return "…";
}

std::vector<std::string> Pen::wrapped(const std::string& text, const Font& font, double width) {
  std::vector<std::string> lines{""};
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const std::string longer = lines.back().empty() ? word : lines.back() + " " + word;
    if (!lines.back().empty() && text_width(longer, font) > width)
      lines.push_back(fitted(word, font, width));
    else
      lines.back() = lines.back().empty() ? fitted(word, font, width) : longer;
    begin = end + 1;
  }
  return lines;
}

}  // namespace isopach
