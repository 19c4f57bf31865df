#include "mesh_file/byte_source.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"

namespace togishi {
namespace {

constexpr std::size_t buffer_size = std::size_t{1} << 18U;
constexpr std::size_t longest_word = 200;

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}
bool ends_line(char c) {
    return c == '\n' || c == '\r';
}

}  // namespace

ByteSource::ByteSource(std::istream& in, std::uint64_t size, std::string where)
    : in_(in), size_(size), where_(std::move(where)), buffer_(buffer_size) {}

void ByteSource::fill() {
    if (ended_) return;
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    while (end_ < buffer_.size() && !ended_) {
        in_.read(buffer_.data() + end_, static_cast<std::streamsize>(buffer_.size() - end_));
        const auto got = static_cast<std::size_t>(in_.gcount());
        if (in_.bad()) throw InputError(where_, "file", "unreadable", "a file that you may read");
        ended_ = !in_;
        end_ += got;
        read_ += got;
    }
}

bool ByteSource::skip(std::uint64_t count) {
    while (count > 0) {
        if (begin_ == end_) fill();
        if (begin_ == end_) return false;
        const std::uint64_t step = std::min<std::uint64_t>(count, end_ - begin_);
        begin_ += step;
        count -= step;
    }
    return true;
}

void ByteSource::skip_blanks(bool over_lines) {
    for (;;) {
        while (begin_ < end_) {
            const char c = buffer_[begin_];
            if (over_lines && ends_line(c)) {
                // CRLF counts once, by its LF; a lone CR is no line end that anybody writes today.
                line_ += c == '\n' ? 1 : 0;
            } else if (!is_blank(c)) {
                return;
            }
            ++begin_;
        }
        fill();
        if (begin_ == end_) return;
    }
}

std::string_view ByteSource::take_word() {
    if (end_ - begin_ <= longest_word) fill();
    std::size_t end = begin_;
    while (end < end_ && !is_blank(buffer_[end]) && !ends_line(buffer_[end])) {
        if (++end - begin_ > longest_word) {
            throw InputError(where_ + ", line " + std::to_string(line_), "text",
                             shown({buffer_.data() + begin_, longest_word}),
                             "words of at most 200 characters");
        }
    }
    const std::string_view word(buffer_.data() + begin_, end - begin_);
    begin_ = end;
    return word;
}

std::string_view ByteSource::word_of_line() {
    for (;;) {
        skip_blanks(false);
        const std::string_view next = peek(3);
        if (next.empty() || ends_line(next[0])) return {};
        const bool goes_on =
            next.starts_with("\\\n") || next.starts_with("\\\r\n") || next == "\\\r";
        if (!goes_on) return take_word();
        skip_line();
    }
}

void ByteSource::skip_line() {
    for (;;) {
        while (begin_ < end_) {
            const char c = buffer_[begin_++];
            if (c != '\n') continue;
            ++line_;
            return;
        }
        fill();
        if (begin_ == end_) return;
    }
}

std::string ByteSource::line_text() {
    std::string text;
    for (;;) {
        const std::string_view next = peek(2);
        if (next.empty()) return text;
        const char c = next[0];
        const bool crlf = next == "\r\n";
        begin_ += crlf ? 2 : 1;
        if (ends_line(c)) {
            ++line_;
            return text;
        }
        text += c;
        if (text.size() > most_taken) {
            throw InputError(where_ + ", line " + std::to_string(line_), "text", shown(text),
                             "lines of at most 4096 characters");
        }
    }
}

}  // namespace togishi
