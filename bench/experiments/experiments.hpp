// The experiments. Each measures one thing and writes its part of the page.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "bench/support/page.hpp"

namespace isopach::bench {

struct Setup {
  bool quick = false;
  std::size_t n = 1'000'000;
  int repeats = 5;
  int slow_repeats = 3;                  ///< of whole comparisons and processes
  bool four_million = true;              ///< also with 4·10⁶ points
  std::vector<std::size_t> sizes;        ///< of the experiments on growth
  std::vector<std::size_t> worst_sizes;  ///< of the constructed worst case
  std::filesystem::path self, programs, shared, scratch, docs;
};

void processes(const Setup& setup, Page& page);   ///< first: it needs this process to be small
void memory(const Setup& setup, Page& page);      ///< bytes a point, in processes of their own
void contention(const Setup& setup, Page& page);  ///< what a busy second core costs the first
void delaunay(const Setup& setup, Page& page);    ///< four families
void cliffs(const Setup& setup, Page& page);      ///< hostile families against uniform
void stages(const Setup& setup, Page& page);      ///< tree, localisation, merge
void whole(const Setup& setup, Page& page);       ///< the comparison in memory
void growth(const Setup& setup, Page& page);      ///< figure 3, with real scans; ns per node against n
void worst_case(const Setup& setup, Page& page);  ///< quadratic along the tree, linear by interface
void scipy(const Setup& setup, Page& page);       ///< Qhull through SciPy, if there

/// What `memory` runs as a process: prints the peak above the input, bytes a point.
int memory_probe(const std::string& whose, std::size_t n);

}  // namespace isopach::bench
