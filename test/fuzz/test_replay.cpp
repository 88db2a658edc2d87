// Runs a fuzz target without libFuzzer, so that every build exercises it: over its seeds, over inputs that
// once failed (test/fuzz/failures/<target>/), and over simple mutations of both, always the same ones.
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "test/fuzz/target.hpp"

namespace extperfc::fuzz {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kLongest = std::chrono::seconds(2);  // mutations end then; how many there were is no promise
constexpr int kMaxMutations = 20'000;

std::vector<std::string> inputs() {
  auto all = seeds();
  const std::filesystem::path folder(EXTPERFC_SOURCE_DIR "/test/fuzz/failures/" EXTPERFC_FUZZ_TARGET);
  if (!std::filesystem::is_directory(folder)) return all;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream file(entry.path(), std::ios::binary);
    all.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return all;
}

std::size_t below(Rng& rng, std::size_t size) {
  return static_cast<std::size_t>(rng.integer(0, static_cast<int>(size) - 1));
}

/// One edit: another byte, a byte more or less, an end that is missing, or a piece of another input.
void mutate(std::string& text, const std::string& other, Rng& rng) {
  const std::size_t at = text.empty() ? 0 : below(rng, text.size());
  const auto byte = static_cast<char>(rng.integer(0, 255));
  switch (rng.integer(0, 4)) {
    case 0:
      if (!text.empty()) text[at] = byte;
      break;
    case 1:
      text.insert(at, 1, byte);
      break;
    case 2:
      if (!text.empty()) text.erase(at, 1 + below(rng, 4));
      break;
    case 3:
      text.resize(at);
      break;
    default:
      if (!other.empty()) text.insert(at, other.substr(below(rng, other.size()), 1 + below(rng, 20)));
      break;
  }
}

TEST(FuzzReplay, SeedsAndFailures) {
  const auto all = inputs();
  ASSERT_FALSE(all.empty());
  for (const auto& input : all) run(input);
}

TEST(FuzzReplay, Mutations) {
  const auto all = inputs();
  Rng rng(4);
  const auto end = Clock::now() + kLongest;
  int done = 0;
  for (; done < kMaxMutations && Clock::now() < end; ++done) {
    std::string text = all[below(rng, all.size())];
    const int edits = rng.integer(1, 4);
    for (int i = 0; i < edits; ++i) mutate(text, all[below(rng, all.size())], rng);
    run(text);
  }
  RecordProperty("mutations", done);
  EXPECT_GT(done, 0);
}

}  // namespace
}  // namespace extperfc::fuzz
