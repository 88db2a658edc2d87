#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "extperfc/translate/schema.hpp"

namespace extperfc::translate {

/// Where a message's definition comes from; a later value counts more.
enum class Origin : unsigned char {
  kLearned,  ///< a connection header
  kHalf,     ///< request or response of a service
  kDerived,  ///< one of the messages of an action
  kOwn,      ///< a definition of its own
};

/// The version of each type that one workspace has.
struct DefinitionSet {
  std::map<std::string, SchemaPtr, std::less<>> messages;  ///< with those derived from actions
  std::map<std::string, ServicePtr, std::less<>> services;
  std::map<std::string, ActionPtr, std::less<>> actions;
};

/// All versions of all types. Equal definitions are kept once: what add() returns takes the place of what it
/// was given. One type may have several layouts with one MD5 (`Point p`, `Point[] p`): a key distinguishes
/// them apart, which is the MD5 of the first, and the MD5 with "-2", "-3" of the others.
class Catalogue {
 public:
  struct Message {
    SchemaPtr schema;
    std::string key;
    Origin origin{Origin::kOwn};
  };
  struct Service {
    ServicePtr schema;
    std::string key;
  };
  struct Action {
    ActionPtr schema;
    std::string key;  ///< of the message <Name>Action
  };
  template <typename T>
  using Versions = std::map<std::string, std::vector<T>, std::less<>>;

  SchemaPtr add(const SchemaPtr& schema, Origin origin);
  ServicePtr add(const ServicePtr& schema);  ///< and its halves
  ActionPtr add(const ActionPtr& schema);    ///< and its messages

  /// `set` is made when it is new; a version of the same type in it is replaced.
  void put(const std::string& set, const SchemaPtr& schema);
  void put(const std::string& set, const ServicePtr& schema);
  void put(const std::string& set, const ActionPtr& schema);  ///< with its messages

  [[nodiscard]] const Message* find_message(std::string_view type, std::string_view key) const;
  [[nodiscard]] const Service* find_service(std::string_view type, std::string_view key) const;
  [[nodiscard]] const Action* find_action(std::string_view type, std::string_view key) const;
  [[nodiscard]] const DefinitionSet* find_set(std::string_view set) const;
  /// The version that equals `schema` in layout too; null when there is none.
  [[nodiscard]] const Message* find_equal(const SchemaPtr& schema) const;
  /// The key of a schema that is here, or its MD5.
  [[nodiscard]] std::string key_of(const MessageSchema& schema) const;

  [[nodiscard]] const Versions<Message>& messages() const { return messages_; }
  [[nodiscard]] const Versions<Service>& services() const { return services_; }
  [[nodiscard]] const Versions<Action>& actions() const { return actions_; }
  [[nodiscard]] const std::map<std::string, DefinitionSet, std::less<>>& sets() const { return sets_; }

 private:
  Versions<Message> messages_;
  Versions<Service> services_;
  Versions<Action> actions_;
  std::map<std::string, DefinitionSet, std::less<>> sets_;
};

/// The seven messages of an action.
[[nodiscard]] std::vector<SchemaPtr> messages_of(const ActionSchema& action);
/// The version of a set, also when it is half of a service; null when there is none.
[[nodiscard]] SchemaPtr find_in(const DefinitionSet& set, std::string_view type);

}  // namespace extperfc::translate
