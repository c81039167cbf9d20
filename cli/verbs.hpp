// The verbs of the command line: one file each. A verb parses its own arguments, calls the library, prints or writes.
#pragma once
#include <string>
#include <vector>

namespace isopach::cli {

using Arguments = std::vector<std::string>;  ///< what follows the verb

struct Verb {
  std::string name, summary;
  int (*run)(const Arguments& arguments);  ///< returns the exit code; failures are exceptions (base/error.hpp)
};

int run_compare(const Arguments& arguments);
int run_match(const Arguments& arguments);
int run_distance(const Arguments& arguments);
int run_asymmetry(const Arguments& arguments);
int run_accuracy(const Arguments& arguments);
int run_scanners(const Arguments& arguments);
int run_roughness(const Arguments& arguments);
int run_sequence(const Arguments& arguments);
int run_combine(const Arguments& arguments);
int run_info(const Arguments& arguments);
int run_simulate(const Arguments& arguments);
int run_demo(const Arguments& arguments);
int run_convert(const Arguments& arguments);
int run_tile_verb(const Arguments& arguments);

}  // namespace isopach::cli
