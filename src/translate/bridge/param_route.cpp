#include "translate/bridge/param_route.hpp"

#include <utility>

namespace extperfc::translate {

namespace {

bool is_empty_struct(const XmlValue& value) {
  const auto* fields = value.as<XmlStruct>();
  return fields != nullptr && fields->empty();
}

std::string without_slash_at_end(std::string name) {
  while (name.size() > 1 && name.back() == '/') name.pop_back();
  return name;
}

}  // namespace

ParamRoute::ParamRoute(BridgeContext& context, Written& written, std::string prefix, Side from)
    : context_(context), written_(written), prefix_(without_slash_at_end(std::move(prefix))), from_(from) {
  context_.peer(from_).watch_param(
      prefix_, [this, alive = std::weak_ptr<bool>(alive_)](const auto& name, const auto& value) {
        if (!alive.expired()) on_change(without_slash_at_end(name), value);
      });
}

void ParamRoute::write_again() {
  auto& there = written_[static_cast<std::size_t>(other(from_))];
  for (const auto& name : names_) there.erase(name);
  context_.peer(from_).get_param(prefix_,
                                 [this, alive = std::weak_ptr<bool>(alive_)](const Result<XmlValue>& value) {
                                   if (!alive.expired() && value) on_change(prefix_, *value);
                                 });
}

void ParamRoute::on_change(const std::string& name, const XmlValue& value) {
  // A namespace is written leaf by leaf, to keep values that only the other side has.
  if (const auto* fields = value.as<XmlStruct>(); fields != nullptr && !fields->empty()) {
    const auto prefix = name == "/" ? name : name + "/";
    for (const auto& [key, part] : *fields) on_change(std::string(prefix).append(key), part);
    return;
  }
  auto& here = written_[static_cast<std::size_t>(from_)];
  auto& there = written_[static_cast<std::size_t>(other(from_))];
  if (const auto echo = here.find(name); echo != here.end() && echo->second == value) return;
  if (const auto known = there.find(name); known != there.end() && known->second == value) return;
  const auto to = other(from_);
  const auto done = [report = context_.problem, name, to](const Result<void>& result) {
    if (!result)
      report("parameter " + name + " on the " + to_string(to) + " side: " + result.error().message);
  };
  here.erase(name);
  if (is_empty_struct(value)) {
    there.erase(name);
    if (names_.erase(name) == 0) return;  // it was never there
    return context_.peer(to).delete_param(name, [](const Result<void>&) {});
  }
  names_.insert(name);
  there[name] = value;
  context_.peer(to).set_param(name, value, done);
}

}  // namespace extperfc::translate
