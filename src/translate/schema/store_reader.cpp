#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "translate/schema/package_tree.hpp"
#include "translate/schema/raw_definition.hpp"
#include "translate/schema/store_files.hpp"

namespace extperfc::translate {
namespace {

namespace fs = std::filesystem;
constexpr std::string_view kEmbeds = "# embeds ";

struct StoredFile {
  std::string type, key;
  fs::path path;
};

std::vector<std::string_view> tokens_of(std::string_view line) {
  std::vector<std::string_view> tokens;
  for (line = strip(line); !line.empty(); line = strip(line)) {
    tokens.push_back(line.substr(0, line.find_first_of(" \t")));
    line.remove_prefix(tokens.back().size());
  }
  return tokens;
}

/// What the leading lines of a stored definition say about the types that it embeds.
std::map<std::string, std::string> read_embeds(std::string_view text) {
  std::map<std::string, std::string> keys;
  while (text.substr(0, kEmbeds.size()) == kEmbeds) {
    const auto tokens = tokens_of(take_line(text).substr(kEmbeds.size()));
    if (tokens.size() == 2) keys.emplace(tokens[0], tokens[1]);
  }
  return keys;
}

class StoreReader {
 public:
  StoreReader(const SchemaLimits& limits, Catalogue& catalogue) : limits_(limits), catalogue_(catalogue) {}

  Result<std::size_t> read(const fs::path& folder) {
    if (auto listed = list(folder); !listed) return tl::unexpected(listed.error());
    for (const auto& [id, file] : messages_)
      if (auto read = read_message(file, 0); !read) return tl::unexpected(read.error());
    for (const auto& file : services_)
      if (auto read = read_service(file); !read) return tl::unexpected(read.error());
    for (const auto& file : actions_)
      if (auto read = read_action(file); !read) return tl::unexpected(read.error());
    for (const auto& file : sets_)
      if (auto read = read_set(file); !read) return tl::unexpected(read.error());
    return messages_.size() + services_.size() + actions_.size();
  }

 private:
  using Id = std::pair<std::string, std::string>;  ///< type, key

  Result<void> list(const fs::path& folder) {
    std::error_code error;
    if (!fs::is_directory(folder / "sets", error))
      return fail(ErrorCode::kNotFound,
                  folder.string() + ": not a store of definitions (it has no folder 'sets')");
    for (const auto& package : sorted(folder)) {
      const auto name = package.filename().string();
      for (const auto& file : fs::is_directory(package, error) ? sorted(package) : std::vector<fs::path>()) {
        if (name == "sets") {
          if (file.extension() == ".txt") sets_.push_back(file);
        } else if (auto listed = list_file(name, file); !listed) {
          return listed;
        }
      }
    }
    return {};
  }

  static std::vector<fs::path> sorted(const fs::path& folder) {
    std::vector<fs::path> found;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
      found.push_back(at->path());
    std::sort(found.begin(), found.end());
    return found;
  }

  Result<void> list_file(const std::string& package, const fs::path& path) {
    const auto kind = std::find_if(
        kDefinitionKinds.begin(), kDefinitionKinds.end(),
        [&](DefinitionKind each) { return path.extension() == std::string(".") + to_string(each); });
    if (kind == kDefinitionKinds.end()) return {};
    const auto stem = path.stem().string();
    const auto dot = stem.find('.');
    StoredFile file{package + "/" + stem.substr(0, dot), dot == std::string::npos ? "" : stem.substr(dot + 1),
                    path};
    if (file.key.empty() || !valid_type_name(file.type))
      return fail(ErrorCode::kCorrupt,
                  path.string() + ": a stored definition is named <Name>.<MD5>" + path.extension().string());
    if (*kind == DefinitionKind::kMessage)
      messages_.emplace(Id(file.type, file.key), std::move(file));
    else
      (*kind == DefinitionKind::kService ? services_ : actions_).push_back(std::move(file));
    return {};
  }

  /// The text and the schemas that its leading lines name; errors when one of them cannot be had.
  struct Source {
    std::string text;
    std::map<std::string, SchemaPtr> embedded;
    [[nodiscard]] FindSchema find() const {
      return [this](const std::string& type) {
        const auto found = embedded.find(type);
        return found == embedded.end() ? nullptr : found->second;
      };
    }
  };
  Result<Source> open(const StoredFile& file, std::size_t depth) {
    auto text = read_text(file.path, limits_.text_bytes);
    if (!text) return tl::unexpected(text.error());
    Source source{*std::move(text), {}};
    for (const auto& [type, key] : read_embeds(source.text)) {
      auto schema = embedded(file, {type, key}, depth);
      if (!schema) return tl::unexpected(schema.error());
      source.embedded.emplace(type, *schema);
    }
    return source;
  }

  Result<SchemaPtr> embedded(const StoredFile& owner, const Id& id, std::size_t depth) {
    if (const auto* known = catalogue_.find_message(id.first, id.second)) return known->schema;
    const auto file = messages_.find(id);
    if (file == messages_.end())
      return fail(ErrorCode::kNotFound, owner.path.string() + ": embeds " + id.first + " " + id.second +
                                            ", which is not in the store");
    if (depth > limits_.depth)
      return fail(ErrorCode::kCorrupt, owner.path.string() + ": embeds itself, or more than " +
                                           std::to_string(limits_.depth) + " definitions in one another");
    return read_message(file->second, depth + 1);
  }

  Result<SchemaPtr> read_message(const StoredFile& file, std::size_t depth) {
    if (const auto* known = catalogue_.find_message(file.type, file.key)) {
      if (known->origin == Origin::kOwn) return known->schema;
    }
    const auto source = open(file, depth);
    if (!source) return tl::unexpected(source.error());
    const auto schema = parse_message(file.type, source->text, source->find(), limits_);
    if (!schema) return fail(schema.error().code, file.path.string() + ": " + schema.error().message);
    if (auto fits = check_key(file, (*schema)->md5()); !fits) return tl::unexpected(fits.error());
    return catalogue_.add(*schema, Origin::kOwn);
  }

  Result<void> read_service(const StoredFile& file) {
    const auto source = open(file, 0);
    if (!source) return tl::unexpected(source.error());
    const auto schema = parse_service(file.type, source->text, source->find(), limits_);
    if (!schema) return fail(schema.error().code, file.path.string() + ": " + schema.error().message);
    catalogue_.add(*schema);
    return check_key(file, (*schema)->md5);
  }

  Result<void> read_action(const StoredFile& file) {
    const auto source = open(file, 0);
    if (!source) return tl::unexpected(source.error());
    const auto schema = parse_action(file.type, source->text, source->find(), limits_);
    if (!schema) return fail(schema.error().code, file.path.string() + ": " + schema.error().message);
    catalogue_.add(*schema);
    return check_key(file, (*schema)->action->md5());
  }

  static Result<void> check_key(const StoredFile& file, const std::string& md5) {
    if (file.key == md5 || file.key.substr(0, md5.size() + 1) == md5 + "-") return {};
    return fail(ErrorCode::kCorrupt, file.path.string() + ": its definition has the MD5 " + md5 +
                                         ": the file is damaged, or was edited");
  }

  Result<void> read_set(const fs::path& file) {
    const auto text = read_text(file, limits_.text_bytes);
    if (!text) return tl::unexpected(text.error());
    std::string_view rest = *text;
    for (std::size_t line = 1; !rest.empty(); ++line) {
      const auto content = take_line(rest);
      const auto tokens = tokens_of(content.substr(0, content.find('#')));
      if (tokens.empty()) continue;
      if (tokens.size() != 3 || !put(file.stem().string(), tokens))
        return fail(ErrorCode::kCorrupt,
                    file.string() + ":" + std::to_string(line) +
                        ": '<type> <msg|srv|action> <key>' of a stored definition is expected");
    }
    return {};
  }

  bool put(const std::string& set, const std::vector<std::string_view>& tokens) {
    if (tokens[1] == "msg") return put(set, catalogue_.find_message(tokens[0], tokens[2]));
    if (tokens[1] == "srv") return put(set, catalogue_.find_service(tokens[0], tokens[2]));
    return tokens[1] == "action" && put(set, catalogue_.find_action(tokens[0], tokens[2]));
  }
  template <typename T>
  bool put(const std::string& set, const T* version) {
    if (version == nullptr) return false;
    catalogue_.put(set, version->schema);
    return true;
  }

  const SchemaLimits& limits_;
  Catalogue& catalogue_;
  std::map<Id, StoredFile> messages_;
  std::vector<StoredFile> services_, actions_;
  std::vector<fs::path> sets_;
};

}  // namespace

Result<std::size_t> read_store(const fs::path& folder, const SchemaLimits& limits, Catalogue& catalogue) {
  auto whole = catalogue;
  auto count = StoreReader(limits, whole).read(folder);
  if (count) catalogue = std::move(whole);
  return count;
}

}  // namespace extperfc::translate
