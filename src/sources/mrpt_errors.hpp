#pragma once

#include <exception>
#include <string>

namespace extperfc::sources {

/// The sentence inside MRPT's multi-line exception text.
inline std::string sentence_of(const std::exception& error) {
  std::string text = error.what();
  if (const auto start = text.find("Message:"); start != std::string::npos) text.erase(0, start + 8);
  text.erase(0, text.find_first_not_of(" \t\n"));
  return text.substr(0, text.find('\n'));
}

}  // namespace extperfc::sources
