// Files that appear whole or not at all; loops whose result does not depend on threads.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <string>
#include <system_error>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"

namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& path) {
    std::ifstream in(path);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::size_t files_in(const fs::path& folder) {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

class AtomicFiles : public ::testing::Test {
  protected:
    void SetUp() override {
        folder = fs::path(::testing::TempDir()) /
                 ::testing::UnitTest::GetInstance()->current_test_info()->name();
        fs::remove_all(folder);
        fs::create_directories(folder);
    }
    void TearDown() override { fs::remove_all(folder); }
    fs::path folder;
};

TEST_F(AtomicFiles, ReplaceWhatStoodThere) {
    togishi::write_text_file(folder / "a.txt", "first");
    togishi::write_text_file(folder / "a.txt", "second");
    EXPECT_EQ(read(folder / "a.txt"), "second");
    EXPECT_EQ(files_in(folder), 1U);
}

TEST_F(AtomicFiles, LeaveTheOldFileWhenGivenUp) {
    togishi::write_text_file(folder / "a.txt", "first");
    {
        const togishi::AtomicFile file(folder / "a.txt");
        std::ofstream(file.path()) << "half";
        EXPECT_EQ(file.path().extension(), ".txt");
    }
    EXPECT_EQ(read(folder / "a.txt"), "first");
    EXPECT_EQ(files_in(folder), 1U);
}

TEST_F(AtomicFiles, LeaveTheOldFileWhenTheDiskIsFull) {
    togishi::write_text_file(folder / "a.txt", "first");
    // A limit on the size of files fails writes as a full disk does.
    const auto previous_handler = std::signal(SIGXFSZ, SIG_IGN);
    rlimit previous{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &previous), 0);
    const rlimit small{4096, previous.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    // In one piece, and in small ones that fail late.
    std::vector<std::string> said;
    for (const std::size_t piece : {std::size_t{1} << 20U, std::size_t{100}}) {
        try {
            togishi::AtomicFile file(folder / "a.txt");
            for (std::size_t done = 0; done < 5000; done += piece)
                file.write(std::string(piece, 'x'));
            file.commit();
            said.emplace_back("no error");
        } catch (const togishi::InputError& error) {
            said.emplace_back(error.what());
        }
    }
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &previous), 0);
    std::signal(SIGXFSZ, previous_handler);
    for (const std::string& sentence : said) {
        EXPECT_NE(sentence.find((folder / "a.txt").string() + ": output is not written whole (" +
                                std::generic_category().message(EFBIG)),
                  std::string::npos)
            << sentence;
    }
    EXPECT_EQ(read(folder / "a.txt"), "first");
    EXPECT_EQ(files_in(folder), 1U);
}

TEST_F(AtomicFiles, RefuseToReplaceAFolder) {
    fs::create_directories(folder / "a.txt" / "inside");
    try {
        togishi::write_text_file(folder / "a.txt", "text");
        FAIL() << "no error";
    } catch (const togishi::InputError& error) {
        const std::string what = error.what();
        EXPECT_NE(what.find("a.txt: output is not to be replaced"), std::string::npos) << what;
    }
    EXPECT_TRUE(fs::is_directory(folder / "a.txt" / "inside"));
    EXPECT_EQ(files_in(folder), 1U);
}

TEST_F(AtomicFiles, NameTheMissingFolder) {
    try {
        togishi::write_text_file(folder / "no" / "a.txt", "text");
        FAIL() << "no error";
    } catch (const togishi::InputError& error) {
        const std::string what = error.what();
        EXPECT_NE(what.find("output folder"), std::string::npos) << what;
        EXPECT_NE(what.find("missing"), std::string::npos) << what;
    }
}

TEST(ParallelFor, CoversEachItemOnce) {
    for (const unsigned threads : {1U, 2U, 7U}) {
        std::vector<int> visits(1001, 0);
        togishi::parallel_for(
            visits.size(), 10,
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) ++visits[i];
            },
            threads);
        EXPECT_EQ(std::accumulate(visits.begin(), visits.end(), 0), 1001);
        EXPECT_EQ(*std::max_element(visits.begin(), visits.end()), 1);
    }
    togishi::parallel_for(0, 10, [](std::size_t, std::size_t) { FAIL(); });
}

TEST(ParallelFor, PassesOnTheFirstFailure) {
    EXPECT_THROW(togishi::parallel_for(
                     100, 1,
                     [](std::size_t begin, std::size_t) {
                         if (begin == 13) throw togishi::InputError("a", "b", "c", "d");
                     },
                     4),
                 togishi::InputError);
}

}  // namespace
