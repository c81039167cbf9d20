// ViewPage: a page with the view of a comparison.
#pragma once
#include <string>
#include <vector>

#include "isopach/report/page/page.hpp"
#include "isopach/report/view/view.hpp"

namespace isopach {

class ViewPage : public HtmlPage {
 public:
  using HtmlPage::HtmlPage;

 protected:
  /// The finished page with the view of these scenes; look.vertices limits it.
  [[nodiscard]] std::string with_view(const std::vector<ViewScene>& scenes, const ViewWords& words,
                                      const MapOptions& look, const Context& context) {
    add_view(view_of(scenes, words, look, {look.vertices, bytes_but_times()}, context), view_policy());
    return out_;
  }
};

}  // namespace isopach
