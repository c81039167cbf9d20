// All failures of the library. Data that cannot be used returns as an exception of one of these types, each carrying
// the exit code of the command line; misuse by the programmer is an assert. A message is one line: what, in which file
// or option, what to do. It names options by key, "@max-edge": whoever shows it spells them, base/option_key.hpp.
#pragma once
#include <stdexcept>
#include <string>

namespace isopach {

enum class ExitCode : int {
  done = 0,
  internal = 1,
  usage = 2,
  input = 3,
  no_overlap = 4,
  not_converged = 5,
  tolerance = 6,
  interrupted = 130
};

class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  [[nodiscard]] ExitCode code() const noexcept { return code_; }
  /// The key of the option that the message begins with, "max-edge" of "@max-edge: 0 is no length"; empty if it begins
  /// with none.
  [[nodiscard]] std::string option() const;

 private:
  ExitCode code_;
};

/// Wrong usage: an option or argument that makes no sense (exit 2).
class UsageError : public Error {
 public:
  explicit UsageError(const std::string& message) : Error(ExitCode::usage, message) {}
};

/// An input that cannot be read or is invalid (exit 3). The message names the file.
class InputError : public Error {
 public:
  explicit InputError(const std::string& message) : Error(ExitCode::input, message) {}
};

/// The scans do not overlap, or less than the required coverage (exit 4).
class OverlapError : public Error {
 public:
  explicit OverlapError(const std::string& message) : Error(ExitCode::no_overlap, message) {}
};

/// The user stopped the run (exit 130).
class Interrupted : public Error {
 public:
  Interrupted() : Error(ExitCode::interrupted, "interrupted: nothing was left half-written") {}
};

}  // namespace isopach
