// What each file of the module adds to it, and the two objects that pass between them.
#pragma once
#include <nanobind/nanobind.h>

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "cli/answer.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/cloud/cloud_view.hpp"

namespace isopach::python {

namespace nb = nanobind;

/// A scan: of a file, whose arrays it owns, or a view of arrays of Python's, which it keeps alive.
struct Scan {
  CloudView view;
  std::shared_ptr<const Cloud> cloud;  ///< that the view is of; null: of arrays of Python's
  nb::object points, faces;            ///< these arrays
  std::vector<std::pair<std::string, nb::object>> attributes;
};

Scan scan_of_cloud(std::shared_ptr<const Cloud> cloud);

/// An answer, and what the scans in it refer to.
struct Found {
  std::unique_ptr<cli::Answer> answer;
  std::string verb;
  std::vector<std::string> words;
  std::vector<nb::object> scans;
  std::mutex writing;
};

void bind_scans(nb::module_& module);
void bind_answers(nb::module_& module);
void bind_places(nb::module_& module);  ///< what is asked of the arrays of cells

}  // namespace isopach::python
