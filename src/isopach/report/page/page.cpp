#include "isopach/report/page/page.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <ios>
#include <iterator>

#include "isopach/base/error.hpp"
#include "isopach/report/page/base64.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach {
namespace {

constexpr Typography fine = Typography::fine;

constexpr const char* style = R"css(
:root{color-scheme:light dark;--paper:#fff;--ink:#1d2126;--soft:#5b636e;--line:#dfe2e6;--tint:#f5f6f7;--bar:#9aa1ab;
--warn:#fff4d6;--warn-line:#d9a514;--accent:#0f4f8b}
@media(prefers-color-scheme:dark){:root{--paper:#15181c;--ink:#e6e8eb;--soft:#9aa3ae;--line:#30363d;--tint:#1d2126;
--bar:#6f7884;--warn:#3a3115;--warn-line:#c99a1a;--accent:#8ab8ea}}
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,
"Helvetica Neue","DejaVu Sans",sans-serif;-webkit-font-smoothing:antialiased}
main{max-width:1060px;margin:0 auto;padding:44px 28px 64px}
h1{font-size:29px;line-height:1.2;margin:0 0 10px;letter-spacing:-.012em;overflow-wrap:anywhere}
h1 span{color:var(--soft);font-weight:400}
h2{font-size:19px;margin:46px 0 12px;letter-spacing:-.005em}
p{margin:0 0 12px;max-width:50em}
.soft{max-width:60em}
.scroll+p{margin-top:12px}
.lead{font-size:20px;line-height:1.45}
.soft,caption,figcaption,footer{color:var(--soft);font-size:14px}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(170px,1fr));gap:1px;margin:26px 0;
border:1px solid var(--line);border-radius:8px;overflow:hidden}
.cards div{box-shadow:0 0 0 1px var(--line);padding:14px 16px}
.cards b{display:block;font-size:22px;font-weight:600;font-variant-numeric:tabular-nums;white-space:nowrap}
.cards b small{font-size:14px;font-weight:400;color:var(--soft)}
.cards span{color:var(--soft);font-size:14px}
.warnings{background:var(--warn);border-left:4px solid var(--warn-line);border-radius:4px;padding:12px 18px;margin:22px 0}
.warnings ul{margin:4px 0 0;padding-left:20px}
figure{margin:26px 0}
figure img{display:block;width:100%;height:auto;border-radius:8px;border:1px solid var(--line);background:#fff}
svg{display:block;width:100%;height:auto;color:var(--soft)}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
th,td{text-align:left;padding:7px 14px 7px 0;border-bottom:1px solid var(--line);vertical-align:baseline}
thead th{font-size:13px;font-weight:500;color:var(--soft)}
tbody th{font-weight:500;min-width:11.5em}
table.told th:first-child{width:14.5em}table.told .n{width:7.5em}table.told .u{width:7em}
table.pairs th{width:17em}
thead th.n{text-align:right;padding-right:6px}
td.n{text-align:right;white-space:nowrap;padding-right:6px}
td.u{color:var(--soft);white-space:nowrap}
td.why{color:var(--soft);font-size:14.5px}
td.wrap{overflow-wrap:anywhere}
code,pre{font:13px/1.45 ui-monospace,SFMono-Regular,Menlo,Consolas,"DejaVu Sans Mono",monospace}
pre{background:var(--tint);border-radius:8px;padding:14px 16px;overflow:auto;max-height:70vh}
summary{cursor:pointer;color:var(--accent)}
footer{margin-top:52px;padding-top:14px;border-top:1px solid var(--line)}
.scroll{overflow-x:auto}
@media(max-width:640px){main{padding:28px 16px}table.told thead{display:none}
table.told tr{display:flex;flex-wrap:wrap;border-bottom:1px solid var(--line);padding:7px 0}
table.told th:first-child,table.told .n,table.told .u{width:auto}
table.told th,table.told td{border:0;padding:0 6px 0 0}table.told th{flex:1}table.told .why{flex:0 0 100%}}
@media print{:root{color-scheme:light;--paper:#fff;--ink:#000;--soft:#444;--line:#bbb;--tint:#f5f5f5;--warn:#fff}
body{font-size:11pt}main{padding:0;max-width:none}details{display:none}figure,tr,.cards{break-inside:avoid}
h2{break-after:avoid}@page{margin:16mm}}
)css";

std::string read_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path + ": the picture cannot be read; write it before the report");
  try {
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  } catch (const std::ios_base::failure&) {
    throw Error(ExitCode::internal, path + ": the picture cannot be read back for the report: is the disk in order?");
  }
}

std::string setting_text(const HtmlPage::Json& setting) {
  if (setting.is_null()) return "–";
  if (setting.is_boolean()) return setting.get<bool>() ? "yes" : "no";
  if (setting.is_string()) return escaped(setting.get<std::string>());
  if (setting.is_number_integer()) return setting.dump();
  if (setting.is_number()) return number(setting.get<double>(), fine);
  std::string list;
  for (const HtmlPage::Json& item : setting) list += (list.empty() ? "" : ", ") + setting_text(item);
  return list.empty() ? "–" : list;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : clean_utf8(text)) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  return out;
}

void HtmlPage::open_page(const std::string& title) {
  out_ +=
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
      "'unsafe-inline'\">\n<title>" +
      escaped(title) + "</title>\n<style>" + style + "</style>\n</head>\n<body>\n<main>\n";
}

std::size_t HtmlPage::bytes_but_times() const {
  Json shown = json_;
  shown.erase("timing_s");
  constexpr std::size_t of_every_page = 100'000, copies = 5;  // its numbers stand in tables, too
  return of_every_page + picture_bytes_ + copies * shown.dump(2).size();
}

void HtmlPage::add_view(const std::string& view, const std::string& policy) {
  if (view.empty()) return;
  constexpr std::string_view styles = "style-src 'unsafe-inline'", end = "</body>\n</html>\n";
  out_.insert(out_.find(styles) + styles.size(), "; " + policy);
  out_.insert(out_.size() - end.size(), view);
}

void HtmlPage::close_page() { out_ += "</main>\n</body>\n</html>\n"; }

void HtmlPage::finish_page(const std::vector<std::string>& left_out) {
  settings(left_out);
  timing();
  raw();
  close_page();
}

const HtmlPage::Json& HtmlPage::at(const std::string& key) const {
  constexpr std::string_view percentiles = "abs_percentiles.";  // dots part names, but for those in a level behind it
  const std::size_t found = key.find(percentiles);
  const std::size_t end = found == std::string::npos ? key.size() : found + percentiles.size();
  std::string pointer = "/" + key;
  std::replace(pointer.begin(), pointer.begin() + static_cast<std::ptrdiff_t>(end) + 1, '.', '/');
  return json_.at(Json::json_pointer(pointer));
}

std::string HtmlPage::datum(const std::string& key, const std::string& shown) const {
  const std::string exact = at(key).dump();
  return "<data data-key=\"" + key + "\" value=\"" + exact + "\" title=\"" + exact + "\">" + shown + "</data>";
}
double HtmlPage::value(const std::string& key) const {
  const Json& v = at(key);
  return v.is_number() ? v.get<double>() : std::nan("");
}
std::string HtmlPage::plain(const std::string& key) const { return datum(key, number(value(key), fine)); }
std::string HtmlPage::brief(const std::string& key, int digits) const {
  return datum(key, number(value(key), fine, digits));
}
std::string HtmlPage::brief_sign(const std::string& key, int digits) const {
  return datum(key, signed_number(value(key), fine, digits));
}
std::string HtmlPage::with_sign(const std::string& key) const { return datum(key, signed_number(value(key), fine)); }
std::string HtmlPage::whole(const std::string& key) const {
  return datum(key, count(at(key).get<std::uint64_t>(), fine));
}
std::string HtmlPage::percent(const std::string& key) const {
  return "<data data-key=\"" + key + "\" data-percent value=\"" + at(key).dump() + "\" title=\"" + at(key).dump() +
         "\">" + fixed_number(100 * value(key), 1, fine) + "</data>";
}
void HtmlPage::card(const std::string& number_html, const std::string& unit_html, const std::string& label) {
  out_ += "<div><b>" + number_html + " <small>" + unit_html + "</small></b><span>" + label + "</span></div>\n";
}
void HtmlPage::row(const std::string& name, const std::string& number_html, const std::string& unit_html,
                   const std::string& why) {
  out_ += "<tr><th scope=\"row\">" + name + "</th><td class=\"n\">" + number_html + "</td><td class=\"u\">" +
          unit_html + "</td><td class=\"why\">" + why + "</td></tr>\n";
}
void HtmlPage::open_table(const std::string& title, const std::string& columns, const std::string& kind) {
  out_ += "<h2>" + title + "</h2>\n<div class=\"scroll\"><table" + kind + ">\n";
  if (!columns.empty()) out_ += "<thead><tr>" + columns + "</tr></thead>\n";
  out_ += "<tbody>\n";
}
void HtmlPage::close_table() { out_ += "</tbody></table></div>\n"; }

void HtmlPage::sign(const std::string& line, const std::string& logo_png) {
  if (!logo_png.empty()) {
    const std::string image = base64(logo_png);
    picture_bytes_ += image.size();
    out_ +=
        "<img alt=\"\" style=\"float:right;max-width:220px;max-height:72px;margin:0 0 12px 24px;padding:4px;"
        "background:#fff\" src=\"data:image/png;base64," +
        image + "\">\n";
  }
  if (!line.empty()) out_ += "<p class=\"soft\">" + escaped(line) + "</p>\n";
}

void HtmlPage::warnings() {
  const Json& list = json_.at("warnings");
  if (list.empty()) return;
  out_ += "<section class=\"warnings\" role=\"note\"><strong>Before you rely on the numbers</strong><ul>\n";
  for (const Json& w : list) out_ += "<li>" + escaped(w.get<std::string>()) + "</li>\n";
  out_ += "</ul></section>\n";
}

void HtmlPage::raw() {
  std::string block = text_;
  for (std::size_t i = 0; (i = block.find('<', i)) != std::string::npos; i += 6) block.replace(i, 1, "\\u003c");
  std::string lines;
  for (std::size_t i = 0, end = 0; i < text_.size(); i = end + 1) {
    end = std::min(text_.find('\n', i), text_.size());
    lines += escaped(std::string_view(text_).substr(i, end - i)) + "\n";
  }
  out_ += "<h2>Everything, exactly</h2>\n<details><summary>result.json</summary><pre>" + lines +
          "</pre></details>\n<script type=\"application/json\" id=\"result\">" + block + "</script>\n";
  out_ += "<footer>" + escaped(at("tool.name").get<std::string>()) + " " +
          escaped(at("tool.version").get<std::string>()) + " · schema " + escaped(at("schema").get<std::string>()) +
          " · numbers on this page are rounded; point at one to see it in full</footer>\n";
}

void HtmlPage::picture(const std::string& png, const std::string& alt, const std::string& caption) {
  picture_of(read_bytes(png), alt, caption);
}

void HtmlPage::picture_of(const std::string& png_bytes, const std::string& alt, const std::string& caption) {
  const std::string image = base64(png_bytes);
  picture_bytes_ += image.size();
  out_ += "<figure><img alt=\"" + escaped(alt) + "\" src=\"data:image/png;base64," + image + "\">\n" +
          (caption.empty() ? "" : "<figcaption>" + caption + "</figcaption>\n") + "</figure>\n";
}

void HtmlPage::settings(const std::vector<std::string>& left_out) {
  open_table("Options in force", "", " class=\"pairs\"");
  for (const auto& [name, setting] : json_.at("parameters").items()) {
    if (std::find(left_out.begin(), left_out.end(), name) != left_out.end()) continue;
    const bool is_number = setting.is_number();
    const std::string shown = is_number ? datum("parameters." + name, setting_text(setting)) : setting_text(setting);
    out_ += "<tr><th scope=\"row\"><code>" + escaped(name) + "</code></th><td class=\"wrap\">" + shown + "</td></tr>\n";
  }
  close_table();
}

void HtmlPage::timing() {
  open_table("Time", "", " class=\"pairs\"");
  for (const auto& [stage, seconds] : json_.at("timing_s").items()) {
    std::string words = stage;
    std::replace(words.begin(), words.end(), '_', ' ');
    out_ += "<tr><th scope=\"row\">" + escaped(words) + "</th><td>" +
            datum("timing_s." + stage, number(value("timing_s." + stage), fine, 3)) + " s</td></tr>\n";
  }
  close_table();
}

}  // namespace isopach
