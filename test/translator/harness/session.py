"""Two masters, nodes of both eras and the translator between them."""

import yaml

from harness import eras, network, processes

NAME = "/extperfc_translator"  # of the translator's nodes at both masters, as config/translator.yaml names them
STRING = "std_msgs/String"  # what string() makes


def merged(base, more):
    """`more` over `base`, at any depth."""
    both = dict(base)
    for key, value in more.items():
        both[key] = merged(both[key], value) if isinstance(value, dict) and isinstance(both.get(key), dict) else value
    return both


class Translator(processes.Child):
    """The program. Its parameters are on the workstation's master, as its launch file would set them."""

    def __init__(self, session, name, parameters):
        self.node = name
        home = name + "_home"
        environment = session.workstation.environment()
        environment["ROS_IP"] = session.network.addresses_between["workstation"]
        shipped = yaml.safe_load((processes.REPO / "config" / "translator.yaml").read_text())
        own = {"robot": {"name": name}, "workstation": {"name": name}}
        session.workstation.ask("setParam", home, merged(merged(shipped, merged(session.parameters(), own)), parameters))
        super().__init__(name.strip("/"), session.network.between,
                         [processes.PROGRAMS / "translator", f"__name:={home[1:]}"], session.folder.path, environment)


class Session:
    """Starts everything; close() ends everything. Nodes start when they are first asked for."""

    def __init__(self, one_host=False):
        self._closing, self._nodes = [], {}
        try:
            self.folder = self._keep(processes.Folder())
            why_not = "asked for one host" if one_host else network.separate_networks_work()
            self.separate = why_not is None
            self.network = self._keep(network.OneHost() if why_not else network.SeparateNetworks())
            self.robot = processes.Master("robot", self.network.robot, self.folder.path)
            self.workstation = processes.Master("workstation", self.network.workstation, self.folder.path)
            for master in (self.robot, self.workstation):
                self._closing.append(master.end)
                master.start()
        except BaseException:
            self.close()
            raise
        self.eras = {era: eras.Era(processes.ERAS / era) for era in ("indigo", "noetic")}

    def _keep(self, resource):
        self._closing.append(resource.close)
        return resource

    def close(self):
        for puppet in self._nodes.values():
            puppet.ask_to_end()
        for close in reversed(self._closing):
            close()

    def parameters(self):
        """Of the translator, as a launch file gives them."""
        between = self.network.addresses_between
        return {
            "robot": {"master_uri": self.robot.uri, "advertised_host": between["robot"],
                    "definitions": ["baxter_sdk_0.7.0", "indigo"]},
            "workstation": {"master_uri": self.workstation.uri, "advertised_host": between["workstation"]},
        }

    def translate(self, **parameters):
        """Starts the translator."""
        self.translator = self.another_translator(NAME, parameters)
        return self.translator

    def another_translator(self, name, parameters):
        """A second one; its end() is the caller's."""
        translator = Translator(self, name, parameters)
        self._closing.append(translator.end)
        processes.wait_until(lambda: name + "_home" in self.names(self.workstation), 20,
                             lambda: f"{name}: {translator.log_tail()}")
        return translator

    def names(self, master):
        """Nodes that a master knows."""
        return {node for listed in master.ask("getSystemState") for _, nodes in listed for node in nodes}

    def start(self, *names):
        """Starts several nodes at once, which is quicker than one after another."""
        started = [name for name in names if name not in self._nodes]
        for name in started:
            self._launch(name, "indigo" if name.startswith("robot") else "noetic")
        for name in started:
            self._nodes[name].wait_ready()
        return [self._nodes[name] for name in names]

    def foreign(self, name):
        """A node of the other side's era."""
        self._launch(name + "_foreign", "noetic" if name.startswith("robot") else "indigo")
        return self._nodes[name + "_foreign"].wait_ready()

    def _launch(self, name, era):
        puppet = processes.Puppet(name, era, name.split("_")[1], self.master_of(name))
        self._nodes[name] = puppet
        self._closing.append(puppet.end)

    def node(self, name):
        """robot_cpp, robot_python, workstation_cpp, workstation_python, with anything behind: workstation_cpp_2."""
        return self.start(name)[0]

    def end_node(self, name, kill=False):
        puppet = self._nodes.pop(name)
        self._closing.remove(puppet.end)
        if kill:
            puppet.kill()
        puppet.end()

    def master_of(self, name):
        return self.robot if name.startswith("robot") else self.workstation

    def era_of(self, name):
        return self.eras["indigo" if name.startswith("robot") else "noetic"]

    def message(self, node_name, type_name, **fields):
        """A message of the era of a node; fields may be nested: {"pose": {"position": {"x": 1}}}."""
        return _set_fields(self.era_of(node_name).message(type_name)(), fields)

    def string(self, text):
        """A std_msgs/String as nodes publish it; its bytes are the same in both eras."""
        return eras.to_hex(self.message("robot", STRING, data=text))

    def flow(self, source, target, topic, text, seconds=20):
        """Sends a text again and again until it arrives."""
        def arrived():
            source.send("publish", topic, self.string(text))
            return text in target.texts(topic)
        processes.wait_until(arrived, seconds, lambda: f"{text} from {source.name} to {target.name}; "
                             f"translator: {self.translator.log_tail(5)}")


def _set_fields(message, fields):
    for name, value in fields.items():
        if isinstance(value, dict):
            _set_fields(getattr(message, name), value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            kind = eras.class_of(type(message), message._slot_types[message.__slots__.index(name)].split("[")[0])
            setattr(message, name, [_set_fields(kind(), each) for each in value])
        else:
            setattr(message, name, value)
    return message


def both_directions():
    """(from, to) of the two directions."""
    return (("robot", "workstation"), ("workstation", "robot"))
