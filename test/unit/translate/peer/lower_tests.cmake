# Event loop, XML-RPC, master.
