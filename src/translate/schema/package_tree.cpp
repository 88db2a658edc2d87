#include "translate/schema/package_tree.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <set>
#include <system_error>

#include "translate/schema/raw_definition.hpp"

namespace extperfc::translate {
namespace {

namespace fs = std::filesystem;

/// The name in package.xml, else the folder's.
std::string package_name(const fs::path& folder) {
  constexpr std::size_t kManifestBytes = 1U << 16U;
  const std::string_view open = "<name>";
  if (const auto text = read_text(folder / "package.xml", kManifestBytes)) {
    const auto begin = text->find(open);
    const auto end = text->find("</name>", begin == std::string::npos ? 0 : begin);
    if (begin != std::string::npos && end != std::string::npos)
      return std::string(
          strip(std::string_view(*text).substr(begin + open.size(), end - begin - open.size())));
  }
  return folder.filename().string();
}

class PackageFinder {
 public:
  /// `real` is the folder without links.
  void visit(const fs::path& real, int depth) {
    if (!seen_.insert(real.string()).second) return;
    const auto found = children(real);
    const auto has = [&](const char* name) {
      return std::any_of(found.begin(), found.end(),
                         [&](const auto& child) { return child.path().filename() == name; });
    };
    if (has("CATKIN_IGNORE")) return;
    bool is_package = has("package.xml");
    for (const auto kind : kDefinitionKinds)
      if (has(to_string(kind))) is_package = read_definitions(real, kind) || is_package;
    if (is_package || depth == 0) return;
    for (const auto& child : found) visit_child(child, depth - 1);
  }
  PackageTree take() {
    std::sort(tree_.files.begin(), tree_.files.end(),
              [](const auto& a, const auto& b) { return a.path < b.path; });
    return std::move(tree_);
  }

 private:
  void visit_child(const fs::directory_entry& child, int depth) {
    std::error_code error;
    if (child.path().filename().string().front() == '.' || !child.is_directory(error)) return;
    if (!child.is_symlink(error)) return visit(child.path(), depth);
    const auto real = fs::canonical(child.path(), error);
    if (!error) visit(real, depth);
  }

  /// Sorted, so that the result does not depend on the file system.
  std::vector<fs::directory_entry> children(const fs::path& folder) {
    std::vector<fs::directory_entry> found;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
      found.push_back(*at);
    if (error) tree_.problems.push_back(folder.string() + ": " + error.message());
    std::sort(found.begin(), found.end());
    return found;
  }

  /// True when there is one.
  bool read_definitions(const fs::path& package_folder, DefinitionKind kind) {
    std::error_code error;
    const auto folder = package_folder / to_string(kind);
    if (!fs::is_directory(folder, error)) return false;
    std::string package;
    for (const auto& child : children(folder)) {
      if (child.path().extension() != std::string(".") + to_string(kind) || !child.is_regular_file(error))
        continue;
      if (package.empty()) package = package_name(package_folder);
      add(kind, package + "/" + child.path().stem().string(), child.path());
    }
    return !package.empty();
  }

  void add(DefinitionKind kind, std::string type, const fs::path& path) {
    if (valid_type_name(type))
      tree_.files.push_back({kind, std::move(type), path});
    else
      tree_.problems.push_back(path.string() + ": package and file names do not form a type name");
  }

  std::set<std::string> seen_;
  PackageTree tree_;
};

}  // namespace

const char* to_string(DefinitionKind kind) {
  switch (kind) {
    case DefinitionKind::kMessage:
      return "msg";
    case DefinitionKind::kService:
      return "srv";
    case DefinitionKind::kAction:
      return "action";
  }
  return "unknown";
}

Result<PackageTree> find_packages(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    return fail(ErrorCode::kNotFound, folder.string() + ": no such folder of packages");
  PackageFinder finder;
  // The absolute path has a name for the package when the folder is one, also for ".".
  finder.visit(fs::canonical(folder, error), kTreeDepth);
  return finder.take();
}

Result<std::string> read_text(const fs::path& file, std::size_t max_bytes) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return fail(ErrorCode::kNotFound, file.string() + ": cannot be opened");
  std::string text;
  std::array<char, 4096> block{};
  while (in && text.size() <= max_bytes) {
    in.read(block.data(), block.size());
    text.append(block.data(), static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad()) return fail(ErrorCode::kFailed, file.string() + ": cannot be read");
  if (text.size() > max_bytes)
    return fail(ErrorCode::kCorrupt, file.string() + ": longer than " + std::to_string(max_bytes) + " bytes");
  return text;
}

}  // namespace extperfc::translate
