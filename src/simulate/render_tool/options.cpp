#include "simulate/render_tool/options.hpp"

#include <charconv>
#include <functional>
#include <map>
#include <sstream>

#include "extperfc/base/sha256.hpp"

namespace extperfc::simulate {

const char* const kHelp = R"(Writes training images with Pascal VOC boxes from random worlds.

  extperfc-render OUT [options]

OUT gets JPEGImages/000001.jpg, Annotations/000001.xml, ImageSets/Main/{train,val,trainval}.txt, labels.txt and
render.txt (the settings). The same settings write the same files with any number of threads.

Options:
  --count NUMBER          images, 100 by default
  --seed NUMBER           of worlds, views and noise, 1 by default
  --size WIDTHxHEIGHT     640x480 by default; the lens is that of a D435i
  --world FILE            views of this world instead of random ones (config/worlds/README.md)
  --scenes KIND           of the random worlds: ordinary (default: a table in a room), varied (any look and pose,
                          look-alikes, odd light, poor cameras) or mixed (both in turn)
  --max-distance METRES   of the camera from one of the objects, 0.4 to 10; 2.2 (ordinary) and 3.2 (varied) by default
  --classes NAME,NAME...  labels that get boxes, cone,cube,sphere by default
  --min-pixels NUMBER     objects with fewer visible pixels get no box, 40 by default
  --val FRACTION          of the worlds for val.txt, 0 to 1, 0.1 by default
  --supersampling NUMBER  rays per pixel and direction, 1 or 2 (default)
  --sequence              an RGB-D recording instead: a camera moves on an arc about the objects; OUT gets rgb/, depth/,
                          associations.txt, groundtruth.txt (poses) and camera_info.yaml, as tools/demo --source reads them
  --depth                 writes Depth/000001.png too: 16 bit, millimetres, 0 where there is no measurement
  --plain                 no blur, exposure, white balance and noise
  --threads NUMBER        one per processor by default
  --resume                goes on with a folder of the same settings, also with a larger --count
  --help                  this text

In the XML: `truncated` reaches over the image's border, `occluded` is hidden by more than 5 %, `difficult` is visible
by less than 30 %, smaller than 12 pixels, or a cone that shows its base only; `visible` is the fraction that is seen, 0 to 1.
Ctrl-C ends after the images in work; the folder is complete up to there.
Exit status: 0 fine, 1 something went wrong, 2 wrong arguments, 130 interrupted.
)";

namespace {

using Value = const std::string&;

template <typename T>
Result<void> read_number(const std::string& name, Value text, T low, T high, T& value) {
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !(number >= low && number <= high)) {
    std::ostringstream message;
    message << name << " must be a number in [" << low << ", " << high << "], not \"" << text << "\"";
    return fail(ErrorCode::kInvalidArgument, message.str());
  }
  value = number;
  return {};
}

Result<void> read_size(Value text, Options& options) {
  const std::size_t x = text.find('x');
  if (x == std::string::npos)
    return fail(ErrorCode::kInvalidArgument, "--size must be like 640x480, not \"" + text + "\"");
  if (auto read = read_number("--size's width", text.substr(0, x), 64, 4096, options.width); !read)
    return read;
  return read_number("--size's height", text.substr(x + 1), 64, 4096, options.height);
}

Result<void> read_classes(Value text, Options& options) {
  options.classes.clear();
  std::istringstream in(text);
  for (std::string name; std::getline(in, name, ',');)
    if (!name.empty()) options.classes.push_back(name);
  if (options.classes.empty())
    return fail(ErrorCode::kInvalidArgument, "--classes must name at least one label, e.g. cone,cube,sphere");
  return {};
}

const std::map<std::string, Scenes>& scene_kinds() {
  static const std::map<std::string, Scenes> list{
      {"ordinary", Scenes::kOrdinary}, {"varied", Scenes::kVaried}, {"mixed", Scenes::kMixed}};
  return list;
}

Result<void> read_scenes(Value text, Options& options) {
  const auto found = scene_kinds().find(text);
  if (found == scene_kinds().end())
    return fail(ErrorCode::kInvalidArgument,
                "--scenes must be ordinary, varied or mixed, not \"" + text + "\"");
  options.scenes = found->second;
  return {};
}

using Reader = std::function<Result<void>(Value, Options&)>;

const std::map<std::string, Reader>& readers() {
  static const std::map<std::string, Reader> list{
      {"--count", [](Value v, Options& o) { return read_number("--count", v, 1, 999999, o.count); }},
      {"--seed",
       [](Value v, Options& o) { return read_number<std::uint64_t>("--seed", v, 0, UINT64_MAX, o.seed); }},
      {"--size", read_size},
      {"--world",
       [](Value v, Options& o) {
         o.world = v;
         return Result<void>{};
       }},
      {"--scenes", read_scenes},
      {"--classes", read_classes},
      {"--min-pixels",
       [](Value v, Options& o) { return read_number("--min-pixels", v, 1, 1000000, o.min_pixels); }},
      {"--max-distance",
       [](Value v, Options& o) { return read_number("--max-distance", v, 0.4, 10.0, o.max_distance_m); }},
      {"--val", [](Value v, Options& o) { return read_number("--val", v, 0.0, 1.0, o.val); }},
      {"--supersampling",
       [](Value v, Options& o) { return read_number("--supersampling", v, 1, 2, o.supersampling); }},
      {"--threads", [](Value v, Options& o) { return read_number("--threads", v, 0, 256, o.threads); }},
  };
  return list;
}

const std::map<std::string, bool Options::*>& flags() {
  static const std::map<std::string, bool Options::*> list{{"--depth", &Options::depth},
                                                           {"--sequence", &Options::sequence},
                                                           {"--plain", &Options::plain},
                                                           {"--resume", &Options::resume},
                                                           {"--help", &Options::help}};
  return list;
}

}  // namespace

Result<Options> parse_options(const std::vector<std::string>& tokens) {
  Options options;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const std::string& token = tokens[i];
    if (const auto flag = flags().find(token); flag != flags().end()) {
      options.*(flag->second) = true;
    } else if (const auto reader = readers().find(token); reader != readers().end()) {
      if (i + 1 == tokens.size()) return fail(ErrorCode::kInvalidArgument, token + " needs a value");
      if (auto read = reader->second(tokens[++i], options); !read) return tl::unexpected(read.error());
    } else if (token.rfind("--", 0) == 0) {
      return fail(ErrorCode::kInvalidArgument, "unknown option " + token);
    } else if (!options.out.empty()) {
      return fail(ErrorCode::kInvalidArgument,
                  "give one folder, not \"" + options.out.string() + "\" and \"" + token + "\"");
    } else {
      options.out = token;
    }
  }
  if (options.out.empty() && !options.help)
    return fail(ErrorCode::kInvalidArgument, "give a folder to write to");
  return options;
}

std::string fingerprint(const Options& options) {
  std::string world = "random";
  for (const auto& [name, kind] : scene_kinds())
    if (kind == options.scenes && kind != Scenes::kOrdinary) world += " " + name;
  if (!options.world.empty())
    world = options.world.string() + " " + sha256_of_file(options.world).value_or("");
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << "seed: " << options.seed << "\nsize: " << options.width << 'x' << options.height
      << "\nworld: " << world << "\nsupersampling: " << options.supersampling
      << "\nmin_pixels: " << options.min_pixels << "\nval: " << options.val << "\ndepth: " << options.depth
      << "\nplain: " << options.plain << "\nclasses:";
  for (const auto& name : options.classes) out << ' ' << name;
  if (options.max_distance_m > 0) out << "\nmax_distance: " << options.max_distance_m;
  out << '\n';
  return out.str();
}

}  // namespace extperfc::simulate
