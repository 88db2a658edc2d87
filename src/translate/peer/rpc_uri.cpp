#include <charconv>
#include <string>
#include <string_view>

#include "extperfc/translate/rpc.hpp"

namespace extperfc::translate {
namespace {

/// Cuts the scheme off; false when there is none.
bool without_scheme(std::string_view& text) {
  const auto end = text.find("://");
  if (end == std::string_view::npos || end == 0) return false;
  text.remove_prefix(end + 3);
  text = text.substr(0, text.find_first_of("/?#"));
  return true;
}

/// Cuts the host off the front; "" when it is missing.
std::string take_host(std::string_view& text) {
  const bool bracketed = !text.empty() && text[0] == '[';
  const auto end = bracketed ? text.find(']') : text.find(':');
  if (bracketed && end == std::string_view::npos) return {};
  auto host = std::string(bracketed ? text.substr(1, end - 1) : text.substr(0, end));
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + (bracketed ? 1 : 0));
  return host;
}

}  // namespace

Result<HostPort> parse_uri(std::string_view uri) {
  constexpr std::size_t kShown = 200;
  const auto refuse = [&uri](const char* what) {
    return fail(ErrorCode::kInvalidArgument, "'" + std::string(uri.substr(0, kShown)) + "' has no " + what +
                                                 "; write it like http://host:11311/");
  };
  auto rest = uri;
  if (!without_scheme(rest)) return refuse("scheme");
  HostPort result;
  result.host = take_host(rest);
  if (result.host.empty() || result.host.find_first_of(" \t\r\n\"<>@") != std::string::npos)
    return refuse("host");
  if (rest.empty() || rest[0] != ':') return refuse("port");
  rest.remove_prefix(1);
  const auto [end, problem] = std::from_chars(rest.data(), rest.data() + rest.size(), result.port);
  if (problem != std::errc() || end != rest.data() + rest.size() || result.port == 0) return refuse("port");
  return result;
}

}  // namespace extperfc::translate
