// Fuzz target: any bytes as a file of a pose, and as a result of match that holds the covariance of one. A pose that
// is read is written and read again, without a change.
#include "cli/parse.hpp"
#include "cli/registration.hpp"
#include "isopach/report/match.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/memory_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace isopach;
  const fuzz::ExactBytes copy(data, size);
  static fuzz::MemoryFile file;
  const std::string path = file.with(copy.bytes());
  fuzz::only_errors([&] {
    const Pose pose = cli::read_pose(path);
    for (const double m : pose.m) fuzz::require_finite("pose", {m});
    const std::string text = pose_text(pose);
    fuzz::require(cli::read_pose(file.with({text.data(), text.size()})).m == pose.m,
                  "a pose is read as it was written");
  });
  fuzz::only_errors([&] {
    const cli::RegistrationError error = cli::parse_registration(file.with(copy.bytes()));
    for (const double c : error.covariance->matrix) fuzz::require_finite("covariance", {c});
  });
  return 0;
}
