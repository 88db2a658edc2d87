#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/base/arguments.hpp"
#include "extperfc/base/text.hpp"

#include "translate/tool/command.hpp"
#include "translate/tool/sources.hpp"
#include "translate/tool/type_definitions.hpp"

namespace extperfc::translate {
namespace {

constexpr const char* kMd5Help = R"(Prints the MD5 of a message, service or action, as genmsg computes it.

  extperfc-translate md5 TYPE                    of every definition in the store, with the sets that contain it
  extperfc-translate md5 TYPE --set SET          of the definition in the set
  extperfc-translate md5 TYPE --tree DIR[:DIR]   of the definition in a tree of packages; embedded types that the
                                                 tree lacks come from --set, "noetic" by default
  extperfc-translate md5 TYPE --file FILE        of a file .msg, .srv or .action; embedded types come from --set

Options:
  --kind msg|srv|action   if the name stands for several kinds
  --config DIR            the folder with definitions/

TYPE is package/Name. An action's MD5 is that of its message <Name>Action.
)";

using TypeDefinitions = std::vector<std::pair<std::string, TypeDefinition>>;  ///< kind, version

Result<std::string> read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  if (!in || !(text << in.rdbuf() || in.peek() == std::ifstream::traits_type::eof()))
    return fail(ErrorCode::kNotFound, file.string() + ": cannot be read");
  return text.str();
}

template <typename T>
Result<TypeDefinitions> as_definitions(const std::string& kind, const std::filesystem::path& file,
                                       const Result<T>& parsed) {
  if (!parsed) return fail(parsed.error().code, file.string() + ": " + parsed.error().message);
  return TypeDefinitions{{kind, definition_of(*parsed)}};
}

Result<TypeDefinitions> of_file(const DefinitionStore& store, const std::string& type,
                                const std::filesystem::path& file, const std::string& set) {
  if (auto known = check_set(store, set); !known) return tl::unexpected(known.error());
  const auto text = read_file(file);
  if (!text) return tl::unexpected(text.error());
  const auto find = [&](const std::string& embedded) { return store.message_of_set(set, embedded); };
  const auto suffix = file.extension();
  if (suffix == ".srv") return as_definitions("srv", file, parse_service(type, *text, find));
  if (suffix == ".action") return as_definitions("action", file, parse_action(type, *text, find));
  if (suffix == ".msg") return as_definitions("msg", file, parse_message(type, *text, find));
  return fail(ErrorCode::kInvalidArgument, file.string() + ": the suffix must be .msg, .srv or .action");
}

Result<TypeDefinitions> of_set(const DefinitionStore& store, const std::string& type,
                               const std::string& set) {
  if (auto known = check_set(store, set); !known) return tl::unexpected(known.error());
  const auto found = find_definitions(store, type, set);
  if (!found) return tl::unexpected(found.error());
  return TypeDefinitions{found->begin(), found->end()};
}

Result<TypeDefinitions> of_all_sets(const DefinitionStore& store, const std::string& type) {
  TypeDefinitions definitions;
  std::set<std::pair<std::string, std::string>> seen;
  for (const auto& set : store.sets()) {
    const auto found = find_definitions(store, type, set);
    if (!found) continue;
    for (const auto& [kind, definition] : *found)
      if (seen.insert({kind, definition.md5}).second) definitions.emplace_back(kind, definition);
  }
  if (definitions.empty())
    return fail(ErrorCode::kNotFound,
                "no set has the type " + type + " (package/Name); --tree and --file read others");
  return definitions;
}

Result<TypeDefinitions> find(DefinitionStore& store, const std::string& type, const Arguments& arguments) {
  const auto set = arguments.last("--set");
  if (const auto file = arguments.last("--file")) return of_file(store, type, *file, set.value_or("noetic"));
  if (const auto tree = arguments.last("--tree")) {
    const std::string name = "tree";
    if (auto read = read_tree(store, *tree, name, set.value_or("noetic")); !read)
      return tl::unexpected(read.error());
    return of_set(store, type, name);
  }
  return set ? of_set(store, type, *set) : of_all_sets(store, type);
}

}  // namespace

Result<int> run_md5(const Tokens& tokens) {
  const auto arguments =
      Arguments::read(tokens, {0, 1, {"--set", "--tree", "--file", "--kind", "--config"}, {"--help"}});
  if (!arguments) return tl::unexpected(arguments.error());
  if (arguments->has("--help")) {
    std::cout << kMd5Help;
    return kFine;
  }
  if (arguments->operands().empty())
    return fail(ErrorCode::kInvalidArgument, "give a type: md5 package/Name");
  auto store = open_store(*arguments);
  if (!store) return tl::unexpected(store.error());
  const auto& type = arguments->operands()[0];
  auto definitions = find(*store, type, *arguments);
  if (!definitions) return tl::unexpected(definitions.error());
  if (const auto kind = arguments->last("--kind"))
    definitions->erase(std::remove_if(definitions->begin(), definitions->end(),
                                      [&](auto& each) { return each.first != *kind; }),
                       definitions->end());
  if (definitions->empty()) return fail(ErrorCode::kNotFound, type + " is not of that kind");
  const bool with_sets = !arguments->has("--set") && !arguments->has("--tree") && !arguments->has("--file");
  for (const auto& [kind, definition] : *definitions) {
    std::cout << definition.md5;
    if (with_sets || definitions->size() > 1) std::cout << " " << kind;
    if (with_sets) std::cout << " " << joined(store->sets_with(type, definition.md5));
    std::cout << "\n";
  }
  return kFine;
}

}  // namespace extperfc::translate
