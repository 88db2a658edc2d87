#include "extperfc/arm/srdf.hpp"

#include <fstream>
#include <locale>
#include <sstream>

#include <tinyxml2.h>

namespace extperfc::arm {
namespace {

using tinyxml2::XMLElement;

/// Reads one document; the first error wins.
class Reader {
 public:
  Result<Srdf> read(const XMLElement& robot) {
    srdf_.robot = text(robot, "name");
    for (const XMLElement* e = robot.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      const std::string kind = e->Name();
      if (kind == "group") read_group(*e);
      if (kind == "group_state") read_state(*e);
      if (kind == "end_effector")
        srdf_.end_effectors.push_back({text(*e, "name"), text(*e, "group"), text(*e, "parent_link"),
                                       optional_text(*e, "parent_group")});
      if (kind == "disable_collisions")
        srdf_.disabled.push_back({text(*e, "link1"), text(*e, "link2"), optional_text(*e, "reason")});
    }
    if (!problem_.empty()) return fail(ErrorCode::kCorrupt, "SRDF: " + problem_);
    return std::move(srdf_);
  }

 private:
  static std::string optional_text(const XMLElement& element, const char* attribute) {
    const char* value = element.Attribute(attribute);
    return value == nullptr ? "" : value;
  }

  std::string text(const XMLElement& element, const char* attribute) {
    std::string value = optional_text(element, attribute);
    if (value.empty() && problem_.empty())
      problem_ = "<" + std::string(element.Name()) + "> in line " + std::to_string(element.GetLineNum()) +
                 " has no " + attribute;
    return value;
  }

  /// In the "C" locale.
  double number(const XMLElement& element, const char* attribute) {
    std::istringstream in(text(element, attribute));
    in.imbue(std::locale::classic());
    double value = 0;
    std::string rest;
    const bool read = static_cast<bool>(in >> value) && !(in >> rest);
    if (!read && problem_.empty())
      problem_ =
          std::string(attribute) + " in line " + std::to_string(element.GetLineNum()) + " is no number";
    return value;
  }

  void read_group(const XMLElement& element) {
    SrdfGroup group;
    group.name = text(element, "name");
    for (const XMLElement* e = element.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      const std::string kind = e->Name();
      if (kind == "joint") group.joints.push_back(text(*e, "name"));
      if (kind == "link") group.links.push_back(text(*e, "name"));
      if (kind == "group") group.groups.push_back(text(*e, "name"));
      if (kind == "chain") {
        std::string base = text(*e, "base_link");
        group.chains.emplace_back(std::move(base), text(*e, "tip_link"));
      }
    }
    srdf_.groups.push_back(std::move(group));
  }

  void read_state(const XMLElement& element) {
    SrdfState state{text(element, "name"), text(element, "group"), {}};
    for (const XMLElement* e = element.FirstChildElement("joint"); e != nullptr;
         e = e->NextSiblingElement("joint"))
      state.positions[text(*e, "name")] = number(*e, "value");
    srdf_.states.push_back(std::move(state));
  }

  Srdf srdf_;
  std::string problem_;
};

void print_named(tinyxml2::XMLPrinter& out, const char* kind, const std::string& name) {
  out.OpenElement(kind);
  out.PushAttribute("name", name.c_str());
  out.CloseElement();
}

void print_group(tinyxml2::XMLPrinter& out, const SrdfGroup& group) {
  out.OpenElement("group");
  out.PushAttribute("name", group.name.c_str());
  for (const auto& name : group.joints) print_named(out, "joint", name);
  for (const auto& name : group.links) print_named(out, "link", name);
  for (const auto& [base, tip] : group.chains) {
    out.OpenElement("chain");
    out.PushAttribute("base_link", base.c_str());
    out.PushAttribute("tip_link", tip.c_str());
    out.CloseElement();
  }
  for (const auto& name : group.groups) print_named(out, "group", name);
  out.CloseElement();
}

std::string shortest(double value) {
  for (int digits = 6;; ++digits) {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out.precision(digits);
    out << value;
    std::istringstream in(out.str());
    in.imbue(std::locale::classic());
    double back = 0;
    in >> back;
    if (back == value || digits == 17) return out.str();
  }
}

void print_state(tinyxml2::XMLPrinter& out, const SrdfState& state) {
  out.OpenElement("group_state");
  out.PushAttribute("name", state.name.c_str());
  out.PushAttribute("group", state.group.c_str());
  for (const auto& [joint, position] : state.positions) {
    out.OpenElement("joint");
    out.PushAttribute("name", joint.c_str());
    out.PushAttribute("value", shortest(position).c_str());
    out.CloseElement();
  }
  out.CloseElement();
}

}  // namespace

Result<Srdf> parse_srdf(const std::string& xml) {
  tinyxml2::XMLDocument document;
  if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS)
    return fail(ErrorCode::kCorrupt, std::string("SRDF: ") + document.ErrorStr());
  const XMLElement* robot = document.FirstChildElement("robot");
  if (robot == nullptr) return fail(ErrorCode::kCorrupt, "SRDF: there is no <robot>");
  return Reader().read(*robot);
}

Result<Srdf> read_srdf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream xml;
  if (!file || !(xml << file.rdbuf()))
    return fail(ErrorCode::kNotFound, "SRDF " + path.string() + " is missing, empty or unreadable");
  auto srdf = parse_srdf(xml.str());
  if (!srdf) return fail(srdf.error().code, path.string() + ": " + srdf.error().message);
  return srdf;
}

std::string to_xml(const Srdf& srdf) {
  tinyxml2::XMLPrinter out;
  out.PushHeader(false, true);
  out.OpenElement("robot");
  out.PushAttribute("name", srdf.robot.c_str());
  for (const auto& group : srdf.groups) print_group(out, group);
  for (const auto& state : srdf.states) print_state(out, state);
  for (const auto& effector : srdf.end_effectors) {
    out.OpenElement("end_effector");
    out.PushAttribute("name", effector.name.c_str());
    out.PushAttribute("parent_link", effector.parent_link.c_str());
    out.PushAttribute("group", effector.group.c_str());
    if (!effector.parent_group.empty()) out.PushAttribute("parent_group", effector.parent_group.c_str());
    out.CloseElement();
  }
  for (const auto& pair : srdf.disabled) {
    out.OpenElement("disable_collisions");
    out.PushAttribute("link1", pair.link_a.c_str());
    out.PushAttribute("link2", pair.link_b.c_str());
    if (!pair.reason.empty()) out.PushAttribute("reason", pair.reason.c_str());
    out.CloseElement();
  }
  out.CloseElement();
  return out.CStr();
}

AllowedPairs allowed_pairs(const Srdf& srdf) {
  AllowedPairs allowed;
  for (const auto& pair : srdf.disabled) allowed.allow(pair.link_a, pair.link_b);
  return allowed;
}

}  // namespace extperfc::arm
