set(EXTPERFC_PEER_LOWER_SOURCES
  event_loop.cpp)
