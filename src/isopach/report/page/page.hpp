// HtmlPage: what all report.html have in common: one page that opens from disk, without a network, complete without a
// script. Every number is taken from the text of result.json, shown rounded, with the exact value as its title and its
// key as data-key. Internal to report/: the header needs nlohmann-json.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace isopach {

/// Text for HTML: valid UTF-8 (see clean_utf8) with & < > " ' as entities.
[[nodiscard]] std::string escaped(std::string_view text);

class HtmlPage {
 public:
  using Json = nlohmann::ordered_json;

  /// `json` is the text of result.json; it outlives the page.
  explicit HtmlPage(const std::string& json) : text_(json), json_(Json::parse(json)) {}

 protected:
  /// Begins the page, with the style of all reports, and ends it.
  void open_page(const std::string& title);
  void close_page();
  /// The end of a report: the objects `parameters` (without those named) and `timing_s` of result.json as tables,
  /// raw(), close_page().
  void finish_page(const std::vector<std::string>& left_out = {});

  /// A value of result.json by its path, "volume.net" or "inputs.0.path".
  [[nodiscard]] const Json& at(const std::string& key) const;
  [[nodiscard]] double value(const std::string& key) const;  ///< NaN for null

  /// A number of result.json: `shown` for people, the exact one as title and value.
  [[nodiscard]] std::string datum(const std::string& key, const std::string& shown) const;
  [[nodiscard]] std::string plain(const std::string& key) const;
  /// With fewer digits: two for a standard deviation, which is known no better.
  [[nodiscard]] std::string brief(const std::string& key, int digits = 3) const;
  [[nodiscard]] std::string brief_sign(const std::string& key, int digits = 3) const;
  [[nodiscard]] std::string with_sign(const std::string& key) const;
  [[nodiscard]] std::string whole(const std::string& key) const;
  [[nodiscard]] std::string percent(const std::string& key) const;

  // Parts of the page; what they are given is HTML already.
  void card(const std::string& number_html, const std::string& unit_html, const std::string& label);
  void row(const std::string& name, const std::string& number_html, const std::string& unit_html,
           const std::string& why);
  void open_table(const std::string& title, const std::string& columns, const std::string& kind = "");
  void close_table();

  /// Whose page it is: a line, as signature() of furniture.hpp gives it, and a logo, PNG; nothing for what is empty.
  void sign(const std::string& line, const std::string& logo_png);
  /// The list `warnings` of result.json; nothing where it is empty.
  void warnings();
  /// A PNG that is written already, carried in the page. Errors: InputError where it cannot be read.
  void picture(const std::string& png, const std::string& alt, const std::string& caption = "");
  /// One of these bytes.
  void picture_of(const std::string& png_bytes, const std::string& alt, const std::string& caption = "");
  /// About the size of the page without a view, and not less: a function of what it shows, but for its times, so that
  /// two runs get the same view.
  [[nodiscard]] std::size_t bytes_but_times() const;
  /// Adds what view_of gave, for view_place; nothing where it is empty. After close_page().
  void add_view(const std::string& view, const std::string& policy);
  /// result.json itself, and the foot of the page.
  void raw();

  const std::string& text_;
  Json json_;
  std::string out_;

 private:
  std::size_t picture_bytes_ = 0;
  void settings(const std::vector<std::string>& left_out);
  void timing();
};

}  // namespace isopach
