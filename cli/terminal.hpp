// Text for people: what reaches a terminal carries no commands to it, and a terminal that is gone is no failure.
#pragma once
#include <string>
#include <string_view>

namespace isopach::cli {

/// `text` with a question mark for every control character but line ends and tabs: names and comments of files may hold
/// escape sequences, which a terminal would obey. Takes UTF-8; the control characters U+0080 to U+009F are among them.
[[nodiscard]] std::string printable(std::string_view text);

/// Messages go to standard error as they are. One that cannot be written (closed, disk full) is lost: the exit code
/// still tells how the run ended.
void write_message(std::string_view text);

/// Is this a pipe whose other end is closed?
[[nodiscard]] bool has_no_reader(int descriptor);

}  // namespace isopach::cli
