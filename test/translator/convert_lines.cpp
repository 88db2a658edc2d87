// Converts messages line by line with the shipped definitions and rules, for tests that know another way to
// read them.
//
//   convert_lines STORE RULES...
//   in:   (msg|req|res) TYPE FROM_MD5 TO_MD5 BYTES      BYTES: "x" and two hexadecimal digits each
//   out:  ok BYTES, or: error TEXT
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/translate/definition_store.hpp"
#include "extperfc/translate/plan.hpp"
#include "extperfc/translate/rules.hpp"

namespace {

using extperfc::translate::ByteBuffer;
using extperfc::translate::DefinitionStore;
using extperfc::translate::Plan;
using extperfc::translate::PlanPtr;
using extperfc::translate::RuleSet;
using extperfc::translate::SchemaPtr;

std::vector<std::uint8_t> from_hex(const std::string& text) {
  const auto value = [](char digit) { return digit <= '9' ? digit - '0' : digit - 'a' + 10; };
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 1; i + 1 < text.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(value(text[i]) * 16 + value(text[i + 1])));
  return bytes;
}

std::string to_hex(const ByteBuffer& bytes) {
  static const char* digits = "0123456789abcdef";
  std::string text = "x";
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    text += digits[bytes.data()[i] >> 4U];
    text += digits[bytes.data()[i] & 15U];
  }
  return text;
}

class Converter {
 public:
  Converter(const DefinitionStore& definitions, const RuleSet& rules)
      : definitions_(definitions), rules_(rules) {}

  std::string answer(const std::string& line) {
    std::istringstream tokens(line);
    std::string part, type, from, to, bytes;
    tokens >> part >> type >> from >> to >> bytes;
    const auto plan = this->plan(part, type, from, to);
    if (!plan.second.empty()) return "error " + plan.second;
    const auto message = from_hex(bytes);
    ByteBuffer out;
    const auto converted = plan.first->convert({message.data(), message.size()}, out);
    return converted ? "ok " + to_hex(out) : "error " + converted.error().message;
  }

 private:
  SchemaPtr schema(const std::string& part, const std::string& type, const std::string& md5) const {
    if (part == "msg") return definitions_.find_message(type, md5);
    const auto service = definitions_.find_service(type, md5);
    if (!service) return nullptr;
    return part == "req" ? service->request : service->response;
  }

  std::pair<PlanPtr, std::string> plan(const std::string& part, const std::string& type,
                                       const std::string& from, const std::string& to) {
    const auto key = part + type + from + to;
    if (const auto known = plans_.find(key); known != plans_.end()) return {known->second, ""};
    const auto source = schema(part, type, from), target = schema(part, type, to);
    if (!source || !target) return {nullptr, type + " is not in the store with MD5 " + (source ? to : from)};
    auto made = Plan::compile(source, target, rules_);
    if (!made) return {nullptr, made.error().message};
    return {plans_[key] = *made, ""};
  }

  const DefinitionStore& definitions_;
  const RuleSet& rules_;
  std::map<std::string, PlanPtr> plans_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  DefinitionStore definitions;
  if (const auto added = definitions.add_store(argv[1]); !added) {
    std::fprintf(stderr, "%s\n", added.error().message.c_str());
    return 1;
  }
  const auto rules = load_rules({argv + 2, argv + argc}, definitions);
  if (!rules) {
    std::fprintf(stderr, "%s\n", rules.error().message.c_str());
    return 1;
  }
  Converter converter(definitions, *rules);
  for (std::string line; std::getline(std::cin, line);) std::cout << converter.answer(line) << '\n';
  return 0;
}
