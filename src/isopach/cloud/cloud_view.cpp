#include "isopach/cloud/cloud_view.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"

namespace isopach {

std::string cloud_name(const CloudView& cloud) { return cloud.path.empty() ? "point cloud" : cloud.path; }

Array<Point3> PointsView::copy() const {
  Array<Point3> own(size_);
  for_each_index(size_, [&](std::size_t i) { own[i] = (*this)[i]; });
  return own;
}

Array<double> ValuesView::copy() const {
  Array<double> own(size_);
  for_each_index(size_, [&](std::size_t i) { own[i] = (*this)[i]; });
  return own;
}

CloudView::CloudView(const Cloud& cloud)
    : points(cloud.points),
      faces(cloud.faces),
      path(cloud.path),
      format(cloud.format),
      unit(cloud.unit),
      vertical_unit(cloud.vertical_unit),
      crs(cloud.crs),
      grid(cloud.grid),
      nodata(cloud.nodata),
      notes(cloud.notes) {
  attributes.reserve(cloud.attributes.size());
  for (const Attribute& a : cloud.attributes) attributes.push_back({a.name, a.values});
}

CloudView::CloudView(Cloud&& cloud) : CloudView(std::make_shared<const Cloud>(std::move(cloud))) {}

CloudView::CloudView(std::shared_ptr<const Cloud> cloud) : CloudView(*cloud) { owner = std::move(cloud); }

const AttributeView* CloudView::find_attribute(std::string_view name) const {
  const auto found = std::find_if(attributes.begin(), attributes.end(), [&](const auto& a) { return a.name == name; });
  if (found == attributes.end()) return nullptr;
  if (found->values.size() != points.size())
    throw InputError(fmt::format("{}: attribute '{}' has {} values for {} points: give one for each point",
                                 cloud_name(*this), name, found->values.size(), points.size()));
  return &*found;
}

void check_faces(const CloudView& view) {
  for (std::size_t i = 0; i < view.faces.size(); ++i)
    for (const Index corner : view.faces[i])
      if (corner >= view.points.size())
        throw InputError(fmt::format("{}: face {} has point {} as a corner, but there are only {} points, from 0 on",
                                     cloud_name(view), i, corner, view.points.size()));
}

Cloud copy_of(const CloudView& view) {
  Cloud cloud;
  cloud.points = view.points.copy();
  for (const AttributeView& a : view.attributes) cloud.attributes.push_back({a.name, a.values.copy()});
  cloud.faces.assign(view.faces.begin(), view.faces.end());
  cloud.path = view.path;
  cloud.format = view.format;
  cloud.unit = view.unit;
  cloud.vertical_unit = view.vertical_unit;
  cloud.crs = view.crs;
  cloud.grid = view.grid;
  cloud.nodata = view.nodata;
  cloud.notes = view.notes;
  return cloud;
}

}  // namespace isopach
