// A file's bytes, words and lines in order, through a buffer: nothing is held that was not asked
// for.
#pragma once
#include <cstdint>
#include <istream>
#include <string>
#include <string_view>
#include <vector>

namespace togishi {

class ByteSource {
  public:
    /// size: the bytes that `in` holds; where: the file's name, for messages.
    ByteSource(std::istream& in, std::uint64_t size, std::string where);

    [[nodiscard]] const std::string& where() const { return where_; }
    [[nodiscard]] std::uint64_t size() const { return size_; }
    [[nodiscard]] std::uint64_t offset() const { return read_ - (end_ - begin_); }
    [[nodiscard]] std::uint64_t left() const { return size_ > offset() ? size_ - offset() : 0; }

    /// The next bytes without taking them: `count` (at most most_taken), fewer at the file's end.
    [[nodiscard]] std::string_view peek(std::size_t count) {
        if (end_ - begin_ < count) fill();
        return {buffer_.data() + begin_, std::min(count, end_ - begin_)};
    }
    /// The next `count` bytes (at most most_taken); nullptr where the file ends before.
    [[nodiscard]] const char* take(std::size_t count) {
        if (end_ - begin_ < count) {
            fill();
            if (end_ - begin_ < count) return nullptr;
        }
        const char* const at = buffer_.data() + begin_;
        begin_ += count;
        return at;
    }
    /// False where the file ends before.
    [[nodiscard]] bool skip(std::uint64_t count);

    /// The next word between blanks and line ends; empty at the file's end. Throws InputError where
    /// it is longer than 200 characters.
    [[nodiscard]] std::string_view word() {
        skip_blanks(true);
        return take_word();
    }
    /// The next word of this line, empty at its end; a backslash at the end goes on in the next
    /// line.
    [[nodiscard]] std::string_view word_of_line();
    /// Takes the rest of the line and its end.
    void skip_line();
    /// A short line without its end (LF, CRLF, CR). Throws InputError where it is longer than 4096.
    [[nodiscard]] std::string line_text();
    /// The number of the line that the next word is looked for in, from 1.
    [[nodiscard]] std::uint64_t line() const { return line_; }

    static constexpr std::size_t most_taken = 4096;

  private:
    void fill();
    void skip_blanks(bool over_lines);
    std::string_view take_word();

    std::istream& in_;
    std::uint64_t size_;
    std::string where_;
    std::vector<char> buffer_;
    std::size_t begin_ = 0, end_ = 0;
    std::uint64_t read_ = 0, line_ = 1;
    bool ended_ = false;
};

}  // namespace togishi
