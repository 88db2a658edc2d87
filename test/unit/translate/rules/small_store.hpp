#pragma once

#include <string>

#include <gtest/gtest.h>

#include "extperfc/translate/definition_store.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::translate {

/// Definitions made for a test: packages in a folder of their own, read into sets.
class SmallStore {
 public:
  /// "pkg/Name.msg" or "pkg/Name.srv" of a set.
  void write(const std::string& set, const std::string& file, const std::string& text) {
    const auto slash = file.find('/');
    const std::string kind = file.substr(file.rfind('.') + 1);
    folder_.write(set + "/" + file.substr(0, slash) + "/" + kind + file.substr(slash), text);
  }
  void read(const std::string& set) {
    const auto report = definitions.add_tree(folder_.path() / set, set);
    ASSERT_TRUE(report) << report.error().message;
    for (const auto& problem : report->problems) ADD_FAILURE() << problem;
  }
  [[nodiscard]] std::string md5(const std::string& set, const std::string& type) const {
    if (const auto message = definitions.message_of_set(set, type)) return message->md5();
    if (const auto service = definitions.service_of_set(set, type)) return service->md5;
    ADD_FAILURE() << set << " has no " << type;
    return "";
  }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_.path(); }

  DefinitionStore definitions;

 private:
  TemporaryFolder folder_;
};

}  // namespace extperfc::translate
