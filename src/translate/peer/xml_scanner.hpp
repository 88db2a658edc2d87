#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

namespace extperfc::translate {

/// Walks over the tags and texts of an XML document without building a tree: what a hostile sender can make
/// us allocate is the text it sent. Texts keep every byte (XML libraries drop strings of blanks, or rewrite
/// line ends). Comments, processing instructions and attributes are passed over; a document type is refused,
/// so that entities cannot be defined.
class XmlScanner {
 public:
  enum class Token { kOpen, kClose, kText, kEnd, kBroken };

  explicit XmlScanner(std::string_view document);

  /// An empty element is an opening and a closing tag.
  Token next();
  /// Of the last tag. Valid as long as the document is.
  [[nodiscard]] std::string_view name() const { return name_; }
  /// Of the last text, entities replaced.
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] std::string take_text() { return std::exchange(text_, {}); }
  /// Offset of what comes next [bytes].
  [[nodiscard]] std::size_t offset() const { return at_; }

 private:
  Token tag();
  Token plain_text();
  Token literal_text();
  bool skip_past(std::string_view end);
  [[nodiscard]] std::size_t end_of_tag(std::size_t from) const;

  std::string_view document_;
  std::size_t at_{0};
  bool close_next_{false};
  std::string_view name_;
  std::string text_;
};

}  // namespace extperfc::translate
