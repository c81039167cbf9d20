// Two scans made in memory: a plane, and the same plane 0.25 higher. rho must be 0.25 in every digit: 0.25 is a power
// of two.
#include <iostream>

#include "isopach/compare/compare.hpp"
#include "isopach/version.hpp"

int main() {
  isopach::Cloud a;
  isopach::Cloud b;
  for (int row = 0; row < 20; ++row)
    for (int column = 0; column < 30; ++column) {
      a.points.push_back({double(column), double(row), 1.0});
      b.points.push_back({double(column), double(row), 1.25});
    }
  const isopach::Comparison comparison = isopach::compare(a, b, isopach::CompareOptions{}, isopach::Context{});
  std::cout << "isopach " << isopach::version << " rho " << comparison.measures.rho << " area "
            << comparison.domain_area << "\n";
  return comparison.measures.rho == 0.25 ? 0 : 1;
}
