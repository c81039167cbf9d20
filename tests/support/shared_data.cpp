#include "tests/support/shared_data.hpp"

namespace isopach::test {

std::filesystem::path source_folder() { return ISOPACH_SOURCE_DIR; }

}  // namespace isopach::test
