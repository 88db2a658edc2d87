# TCPROS streams, the node.
extperfc_add_test(translate/peer/connection_header SOURCES test_connection_header.cpp
  LINK extperfc::translate_peer)
extperfc_add_test(translate/peer/frame_reader SOURCES test_frame_reader.cpp LINK extperfc::translate_peer)
extperfc_add_test(translate/peer/send_queue SOURCES test_send_queue.cpp LINK extperfc::translate_peer)
extperfc_add_test(translate/peer/topics SOURCES test_topics.cpp LINK extperfc::translate_peer)
extperfc_add_test(translate/peer/shared_subscriptions SOURCES test_shared_subscriptions.cpp
  LINK extperfc::translate_peer)
extperfc_add_test(translate/peer/lost_links SOURCES test_lost_links.cpp LINK extperfc::translate_peer)
extperfc_add_test(translate/peer/hostile_peers SOURCES test_hostile_peers.cpp LINK extperfc::translate_peer)
extperfc_add_test(translate/peer/services SOURCES test_services.cpp LINK extperfc::translate_peer)
extperfc_add_test(translate/peer/peer SOURCES test_peer.cpp LINK extperfc::translate_peer)
extperfc_add_test(translate/peer/half_open SOURCES test_half_open.cpp LINK extperfc::translate_peer)
