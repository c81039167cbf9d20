// How the library's messages name options. Errors, warnings and remedies do not know how their reader sets an option:
// they carry its key behind an @, "leave @max-edge out", and whoever shows them adds the spelling. What is told of
// Error::what(), of lists of warnings and of other sentences in results must therefore pass through one of these
// functions.
#pragma once
#include <string>
#include <string_view>

namespace isopach {

/// `text` as it is shown at a command line: "@max-edge" becomes "--max-edge".
///
/// An @ is that of a key where a key of an option follows (option_keys) and ends there, and where none of these stands
/// before it: letter, digit, '.', '/', '_', '-', '@', a quotation mark. So user@host, a@border.ply and '@confidence'
/// (an attribute of points, which the command line writes so) stay as they are. Names of files are not told from keys
/// in any other way: that of a file "@mask" in the current folder is shown as "--mask".
///
/// Text without a key is returned unchanged; so is text that was spelled before. Cost: one pass.
/// Test: tests/base/option_key_test.cpp.
[[nodiscard]] std::string for_shell(std::string text);

/// The same for arguments by keyword, as in Python: "@max-edge" becomes "max_edge".
[[nodiscard]] std::string for_keywords(std::string text);

/// The key that `text` begins with, without its @: "max-edge" of "@max-edge: 0 is no length". Empty if it begins with
/// none.
[[nodiscard]] std::string leading_key(std::string_view text);

/// Whether `key` is one that messages may name: "max-edge".
[[nodiscard]] bool is_option_key(std::string_view key);

}  // namespace isopach
