#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// What every fuzz target has. libFuzzer runs them (tools/fuzz), and so does a unit test, over the seeds and
/// simple mutations of them.
namespace extperfc::fuzz {

/// One input. Returns when nothing went wrong; a broken promise ends the process.
void run(std::string_view input);
/// Inputs to start from.
std::vector<std::string> seeds();

/// Ends the process when a promise of the code under test is broken, with a line that names it.
void require(bool kept, const char* promise);

}  // namespace extperfc::fuzz
