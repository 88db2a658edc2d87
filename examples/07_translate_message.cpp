// Compiles the conversion of a message from ROS Indigo's definition to Noetic's, and runs it.
#include "extperfc/translate/definition_store.hpp"
#include "extperfc/translate/plan.hpp"

#include "examples/example.hpp"

using namespace extperfc;

int main(int argc, char** argv) {
  const std::string type = argc > 1 ? argv[1] : "moveit_msgs/MotionPlanRequest";
  translate::DefinitionStore store;
  (void)examples::value_of(store.add_store(EXTPERFC_SOURCE_DIR "/config/translate/definitions"));
  const auto from = store.message_of_set("indigo", type), to = store.message_of_set("noetic", type);
  if (!from || !to) return std::cerr << type << " is not in both sets of definitions\n", 1;
  std::cout << type << "\n  indigo " << from->md5() << "\n  noetic " << to->md5() << "\n";

  const auto plan = examples::value_of(translate::Plan::compile(from, to, translate::RuleSet{}));
  std::cout << "the translator would " << to_string(plan->kind()) << " it\n";
  for (const auto& note : plan->notes())
    if (note.kind != translate::Plan::Note::Kind::kKept)
      std::cout << "  " << note.path << ": " << note.text << "\n";

  translate::ByteBuffer message, converted;  // bytes as they come from a connection; here all fields are zero
  translate::serialize_default(*from, message);
  examples::check(plan->convert({message.data(), message.size()}, converted));
  std::cout << message.size() << " bytes became " << converted.size() << "\n";
}
