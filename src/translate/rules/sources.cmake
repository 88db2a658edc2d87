# Sources of the rules, relative to src/translate/plan.
set(EXTPERFC_RULES_SOURCES
  ../rules/literal.cpp
  ../rules/load.cpp
  ../rules/path.cpp
  ../rules/rule_reader.cpp
  ../rules/rule_set.cpp
  ../rules/source_reader.cpp)
