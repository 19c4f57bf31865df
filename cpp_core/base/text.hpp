// Reading text that somebody else wrote, piece by piece, without trusting any of it; and words for
// what is told.
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace togishi {

/// Without blanks, tabs and carriage returns at either end.
[[nodiscard]] std::string_view trim(std::string_view text);

/// In quotes, short and printable, for a message.
[[nodiscard]] std::string shown(std::string_view text);

/// Rounded, for a sentence: "737".
[[nodiscard]] std::string whole_number(double value);
/// "737 x 31 x 7 mm".
[[nodiscard]] std::string size_in_mm(double length, double width, double height);

/// A whole field as a number with a decimal point; infinity and NaN as they are written.
[[nodiscard]] std::optional<double> parse_number(std::string_view field);

/// Takes the next line off the front of `text`; LF, CRLF and CR end a line.
[[nodiscard]] std::string_view take_line(std::string_view& text);

/// Takes a byte order mark off. Throws InputError for UTF-16 and for zero bytes.
[[nodiscard]] std::string_view checked_text(std::string_view text, const std::string& where);

/// The text of a user's file. Throws InputError where it is missing, no regular file, unreadable or
/// larger than max_bytes; `what` says what is expected there, e.g. "a CSV file".
[[nodiscard]] std::string read_text_file(const std::filesystem::path& path, std::size_t max_bytes,
                                         const std::string& what);

}  // namespace togishi
