// OpenCASCADE: the whole of the module orasp_occt.so, with detail/occt_shape.cpp the only files
// that include it. One function is found by name: orasp_make_cad_reader_1. It uses headers of the
// library, none of its code.

#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <BRepBndLib.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <Message_ProgressIndicator.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_ExternFile.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TDataStd_TreeNode.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Shape.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_MaterialTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>

#include "orasp/geometry/cad_reader.h"
#include "orasp/geometry/contacts.h"
#include "orasp/geometry/detail/occt_shape.h"
#include "orasp/geometry/detail/plain_text.h"
#include "orasp/model/error.h"

namespace orasp {

namespace {

using Colour = std::array<float, 3>;

/// UTF-8 of a name of the kernel.
std::string text_of(const TCollection_ExtendedString& name) {
  std::string text(static_cast<std::size_t>(name.LengthOfCString()) + 1, '\0');
  Standard_PCharacter begin = text.data();
  text.resize(static_cast<std::size_t>(name.ToUTF8CString(begin)));
  return detail::trimmed(text.c_str());
}

std::string name_of(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  if (!label.FindAttribute(TDataStd_Name::GetID(), name)) return {};
  return text_of(name->Get());
}

/// Names that say what a shape is, not which: exporters write them where they know none.
bool is_nondescript(const std::string& name) {
  static const std::set<std::string> kWords = {"",      "SOLID", "COMPOUND", "SHELL",
                                               "Solid", "Shell", "Compound", "COMPSOLID"};
  return kWords.contains(name) || name.starts_with("=>[") || name.starts_with("NAUO") ||
         name.starts_with("Open CASCADE STEP translator") ||
         name.starts_with("Open_CASCADE_STEP_translator");
}

/// Passes a stop on to the kernel.
class StopIndicator final : public Message_ProgressIndicator {
 public:
  explicit StopIndicator(std::stop_token stop) : stop_(std::move(stop)) {}
  Standard_Boolean UserBreak() override { return stop_.stop_requested(); }
  void Show(const Message_ProgressScope& /*scope*/, const Standard_Boolean /*force*/) override {}

 private:
  std::stop_token stop_;
};

/// A leaf of the product tree, or a solid of one, where it stands.
struct Leaf {
  TopoDS_Shape shape;        ///< in its product's frame
  TopLoc_Location location;  ///< of that frame
  std::string name;
  std::optional<Colour> colour;
  std::string material;
  std::optional<double> density;  ///< kg/m^3
  /// It has no name and lies in the outermost assembly: what was drawn there, in no product.
  bool loose = false;
};

/// The colour of a surface or else of everything: of a label or of a shape.
template <class Coloured>
std::optional<Colour> surface_colour(const Handle(XCAFDoc_ColorTool) & colours,
                                     const Coloured& coloured) {
  Quantity_Color colour;
  for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen}) {
    if (colours->GetColor(coloured, type, colour)) {
      return Colour{static_cast<float>(colour.Red()), static_cast<float>(colour.Green()),
                    static_cast<float>(colour.Blue())};
    }
  }
  return std::nullopt;
}

/// The colour of a product: its own, or that which most of its painted faces and solids have.
std::optional<Colour> product_colour(const Handle(XCAFDoc_ColorTool) & colours,
                                     const TDF_Label& label) {
  if (const auto own = surface_colour(colours, label)) return own;
  TDF_LabelSequence below;
  XCAFDoc_ShapeTool::GetSubShapes(label, below);
  std::map<Colour, int> votes;
  for (const TDF_Label& sub : below) {
    if (const auto colour = surface_colour(colours, sub)) ++votes[*colour];
  }
  std::optional<Colour> best;
  for (const auto& [colour, count] : votes) {
    if (!best || count > votes[*best]) best = colour;
  }
  return best;
}

void read_material(const Handle(XCAFDoc_MaterialTool) & materials, const TDF_Label& product,
                   Leaf& leaf) {
  Handle(TDataStd_TreeNode) node;
  if (!product.FindAttribute(XCAFDoc::MaterialRefGUID(), node) || !node->HasFather()) return;
  Handle(TCollection_HAsciiString) name;
  Handle(TCollection_HAsciiString) description;
  Handle(TCollection_HAsciiString) density_name;
  Handle(TCollection_HAsciiString) density_type;
  double density = 0;
  if (!materials->GetMaterial(node->Father()->Label(), name, description, density, density_name,
                              density_type)) {
    return;
  }
  if (!name.IsNull()) leaf.material = detail::trimmed(name->ToCString());
  constexpr double kPerCubicMetre = 1e6;  // the kernel's are g/mm^3
  if (density > 0) leaf.density = density * kPerCubicMetre;
}

/// The closed shells of a shape that are not part of a solid, and its solids.
std::vector<TopoDS_Shape> bodies_of(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Shape> bodies;
  for (TopExp_Explorer at(shape, TopAbs_SOLID); at.More(); at.Next())
    bodies.push_back(at.Current());
  for (TopExp_Explorer at(shape, TopAbs_SHELL, TopAbs_SOLID); at.More(); at.Next()) {
    if (BRep_Tool::IsClosed(at.Current())) bodies.push_back(at.Current());
  }
  return bodies;
}

/// Reads one file.
class StepFile {
 public:
  StepFile(const std::filesystem::path& shown, const CadReadSettings& settings)
      : shown_(shown), file_(std::filesystem::absolute(shown)), settings_(settings) {}

  CadModel read() {
    load();
    transfer();
    collect();
    build();
    return std::move(model_);
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(shown_.string() + ": " + reason);
  }
  void stop_if_asked() const {
    if (settings_.stop.stop_requested()) throw Interrupted();
  }
  void tell(std::string_view phase, std::size_t done = 0, std::size_t total = 0) const {
    stop_if_asked();
    if (settings_.progress) settings_.progress({.phase = phase, .done = done, .total = total});
  }

  /// Whether the text has the words that open and close a STEP file: the kernel reads what it can
  /// of one that was cut off, and says nothing.
  void require_whole() const {
    std::ifstream stream(file_, std::ios::binary);
    if (!stream) fail("it cannot be opened");
    std::string head(256, '\0');
    stream.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(stream.gcount()));
    if (head.find("ISO-10303-21") == std::string::npos)
      fail("it is not a STEP file, which begins with ISO-10303-21");
    stream.clear();
    stream.seekg(0, std::ios::end);
    const auto size = static_cast<std::streamoff>(stream.tellg());
    if (size < 0) fail("it is no regular file");
    constexpr std::streamoff kTail = 4096;
    stream.seekg(std::max<std::streamoff>(0, size - kTail));
    std::string tail(static_cast<std::size_t>(std::min(size, kTail)), '\0');
    stream.read(tail.data(), static_cast<std::streamsize>(tail.size()));
    if (tail.find("END-ISO-10303-21") == std::string::npos)
      fail("it is cut off: END-ISO-10303-21, with which a STEP file ends, is missing");
  }

  void load() {
    tell("reading");
    require_whole();
    reader_.SetColorMode(true);
    reader_.SetNameMode(true);
    reader_.SetMatMode(true);
    reader_.SetLayerMode(false);
    reader_.SetPropsMode(false);
    reader_.SetGDTMode(false);
    reader_.SetViewMode(false);
    if (reader_.ReadFile(file_.c_str()) != IFSelect_RetDone)
      fail("the STEP reader could not parse it");
    read_unit();
  }

  void read_unit() {
    TColStd_SequenceOfAsciiString lengths;
    TColStd_SequenceOfAsciiString angles;
    TColStd_SequenceOfAsciiString solid_angles;
    reader_.ChangeReader().FileUnits(lengths, angles, solid_angles);
    const std::string name = lengths.IsEmpty() ? "" : detail::trimmed(lengths.First().ToCString());
    static const std::map<std::string, std::pair<std::string, double>> kUnits = {
        {"millimetre", {"mm", 1}},  {"MILLIMETRE", {"mm", 1}},    {"centimetre", {"cm", 10}},
        {"CENTIMETRE", {"cm", 10}}, {"metre", {"m", 1000}},       {"METRE", {"m", 1000}},
        {"INCH", {"inch", 25.4}},   {"inch", {"inch", 25.4}},     {"FOOT", {"foot", 304.8}},
        {"foot", {"foot", 304.8}},  {"micrometre", {"um", 1e-3}}, {"decimetre", {"dm", 100}}};
    const auto known = kUnits.find(name);
    model_.unit = known != kUnits.end() ? known->second.first : name.empty() ? "mm" : name;
    model_.millimetres_per_unit = known != kUnits.end() ? known->second.second : 1;
    if (known == kUnits.end()) {
      model_.warnings.push_back(
          file_.filename().string() +
          (name.empty()
               ? ": it states no unit of length, so millimetres are assumed"
               : ": its unit of length is called \"" + name + "\"; the STEP reader converts it"));
    }
    for (int i = 2; i <= lengths.Length(); ++i) {
      if (detail::trimmed(lengths.Value(i).ToCString()) == name) continue;
      model_.warnings.push_back(file_.filename().string() +
                                ": it holds several units of length; each part is read in its own");
      break;
    }
    if (settings_.millimetres_per_unit) {
      scale_ = *settings_.millimetres_per_unit / model_.millimetres_per_unit;
      model_.millimetres_per_unit = *settings_.millimetres_per_unit;
    }
  }

  void transfer() {
    tell("transferring");
    XCAFApp_Application::GetApplication()->NewDocument("BinXCAF", document_);
    const Handle(StopIndicator) indicator = new StopIndicator(settings_.stop);
    const bool done = reader_.Transfer(document_, indicator->Start());
    stop_if_asked();
    check_references();
    if (!done) fail("it holds no shape");
  }

  /// Files that this one refers to: each must have been read.
  void check_references() const {
    using Files = NCollection_DataMap<TCollection_AsciiString, Handle(STEPCAFControl_ExternFile)>;
    std::set<std::string> missing;
    for (Files::Iterator at(reader_.ExternFiles()); at.More(); at.Next()) {
      if (at.Value()->GetLoadStatus() == IFSelect_RetDone && at.Value()->GetTransferStatus())
        continue;
      missing.insert(std::filesystem::path(at.Key().ToCString()).filename().string());
    }
    if (missing.empty()) return;
    std::string names;
    for (const std::string& name : missing) names += (names.empty() ? "" : ", ") + name;
    fail("it refers to " + names + ", which " + (missing.size() == 1 ? "is" : "are") +
         " not to be found or not to be read beside it");
  }

  void collect() {
    tell("collecting");
    const Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document_->Main());
    colours_ = XCAFDoc_DocumentTool::ColorTool(document_->Main());
    TDF_LabelSequence roots;
    shapes->GetFreeShapes(roots);
    for (const TDF_Label& root : roots) {
      if (model_.name.empty() && !is_nondescript(name_of(root))) model_.name = name_of(root);
      visit(root, TopLoc_Location(), "", std::nullopt, 0);
    }
    if (leaves_.empty()) {
      if (!empty_.empty()) fail("its product \"" + empty_ + "\" has no shape");
      fail("it holds no shape");
    }
    if (!empty_.empty()) {
      model_.warnings.push_back(
          "the product \"" + empty_ +
          "\" has no shape and was left out; a file that it refers to may be missing");
    }
    split();
    if (model_.name.empty()) model_.name = file_.stem().string();
  }

  void visit(const TDF_Label& label, const TopLoc_Location& location, const std::string& parent,
             const std::optional<Colour>& above, int depth) {
    // Assemblies of assemblies multiply: far above what --exclude could bring down to a problem.
    constexpr std::size_t kMostLeaves = 100'000;
    constexpr int kDeepest = 1'000;
    if (leaves_.size() > kMostLeaves) fail("it has more than 100,000 parts");
    if (depth > kDeepest) fail("its assemblies are nested more than 1,000 deep");
    stop_if_asked();
    TDF_Label product = label;
    if (XCAFDoc_ShapeTool::IsReference(label)) XCAFDoc_ShapeTool::GetReferredShape(label, product);
    const TopLoc_Location here = location * XCAFDoc_ShapeTool::GetLocation(label);
    const std::optional<Colour> painted = surface_colour(colours_, label);
    std::string name = name_of(product);
    if (is_nondescript(name)) name = name_of(label);
    const bool nameless = is_nondescript(name);
    if (nameless) name = parent;
    if (XCAFDoc_ShapeTool::IsAssembly(product)) {
      TDF_LabelSequence components;
      XCAFDoc_ShapeTool::GetComponents(product, components);
      for (const TDF_Label& component : components)
        visit(component, here, name, painted ? painted : above, depth + 1);
      return;
    }
    Leaf leaf;
    leaf.shape = XCAFDoc_ShapeTool::GetShape(product);
    leaf.name = name;
    leaf.loose = nameless && depth == 1;
    if (leaf.shape.IsNull() || !TopExp_Explorer(leaf.shape, TopAbs_FACE).More()) {
      if (empty_.empty()) empty_ = name;
      return;
    }
    leaf.location = here * leaf.shape.Location();
    leaf.shape.Location(TopLoc_Location());
    leaf.colour = above;
    if (const auto own = product_colour(colours_, product)) leaf.colour = own;
    if (painted) leaf.colour = painted;
    read_material(XCAFDoc_DocumentTool::MaterialTool(document_->Main()), product, leaf);
    leaves_.push_back(std::move(leaf));
  }

  /// Each body of a leaf becomes one of its own where the leaf is the only one, or loose, or the
  /// user asks for it.
  void split() {
    const bool only = leaves_.size() == 1;
    std::vector<Leaf> split;
    for (const Leaf& leaf : leaves_) {
      const bool wanted = only || leaf.loose || settings_.solids;
      const std::vector<TopoDS_Shape> bodies =
          wanted ? bodies_of(leaf.shape) : std::vector<TopoDS_Shape>();
      if (bodies.size() < 2) {
        split.push_back(leaf);
        continue;
      }
      for (const TopoDS_Shape& body : bodies) split.push_back(body_of(leaf, body));
      if (settings_.solids) continue;
      model_.warnings.push_back((only ? "\"" + leaf.name + "\" is the only product"
                                      : "one shape of the outermost assembly has no name") +
                                ", so each of its " + std::to_string(bodies.size()) +
                                " solids is a part");
    }
    leaves_ = std::move(split);
  }

  Leaf body_of(const Leaf& leaf, const TopoDS_Shape& body) const {
    Leaf one = leaf;
    one.location = leaf.location * body.Location();
    one.shape = body.Located(TopLoc_Location());
    if (const std::string own = entity_name(body); !is_nondescript(own)) one.name = own;
    if (const auto colour = surface_colour(colours_, body)) one.colour = colour;
    return one;
  }

  /// The name of the solid in the file: product trees know names of products alone.
  std::string entity_name(const TopoDS_Shape& body) const {
    const Handle(XSControl_TransferReader) made = reader_.Reader().WS()->TransferReader();
    const auto item =
        Handle(StepRepr_RepresentationItem)::DownCast(made->EntityFromShapeResult(body, 3));
    if (item.IsNull() || item->Name().IsNull()) return {};
    return detail::trimmed(item->Name()->ToCString());
  }

  /// The diagonal of everything, mm, for the default of the tolerance.
  double diagonal() const {
    Bnd_Box box;
    std::map<const void*, Bnd_Box> boxes;
    for (const Leaf& leaf : leaves_) {
      Bnd_Box& own = boxes[leaf.shape.TShape().get()];
      if (own.IsVoid()) BRepBndLib::AddClose(leaf.shape, own);
      if (!own.IsVoid()) box.Add(own.Transformed(leaf.location.Transformation()));
    }
    return box.IsVoid() ? 0 : std::sqrt(box.SquareExtent()) * scale_;
  }

  void build() {
    model_.tolerance = settings_.tolerance ? *settings_.tolerance : default_tolerance(diagonal());
    const double deflection = model_.tolerance / 2 / scale_;
    std::map<const void*, detail::OcctShape> known;
    std::size_t distinct = 0;
    for (const Leaf& leaf : leaves_) known.try_emplace(leaf.shape.TShape().get());
    for (const Leaf& leaf : leaves_) {
      detail::OcctShape& shape = known[leaf.shape.TShape().get()];
      if (shape.key != 0) continue;
      tell("meshing", distinct, known.size());
      shape = detail::meshed(leaf.shape, deflection, settings_.threads > 1);
      shape.key = ++distinct;
    }
    std::size_t measured = 0;
    std::set<const void*> done;
    for (const Leaf& leaf : leaves_) {
      if (!done.insert(leaf.shape.TShape().get()).second) continue;
      tell("volumes", measured++, known.size());
      detail::measure_volume(leaf.shape, known[leaf.shape.TShape().get()]);
    }
    for (const Leaf& leaf : leaves_) add_part(leaf, known[leaf.shape.TShape().get()]);
    if (model_.parts.empty()) fail("none of its shapes has a surface");
  }

  void add_part(const Leaf& leaf, const detail::OcctShape& shape) {
    if (shape.mesh.empty()) {
      model_.warnings.push_back("\"" + leaf.name +
                                "\" has no surface that can be meshed and was left out");
      return;
    }
    CadPart part;
    part.name = leaf.name;
    part.product = std::to_string(shape.key) + " " + leaf.name;
    part.colour = leaf.colour;
    part.material = leaf.material;
    part.density = leaf.density;
    if (shape.failed_faces > 0) {
      model_.warnings.push_back("\"" + leaf.name + "\": " + std::to_string(shape.failed_faces) +
                                " of its faces could not be meshed");
    }
    detail::place(shape, leaf.location.Transformation(), scale_, part);
    model_.parts.push_back(std::move(part));
  }

  std::filesystem::path shown_;  ///< as the user named it
  /// What a file refers to is found beside it by an absolute path alone.
  std::filesystem::path file_;
  const CadReadSettings& settings_;
  STEPCAFControl_Reader reader_;
  Handle(TDocStd_Document) document_;
  Handle(XCAFDoc_ColorTool) colours_;
  std::vector<Leaf> leaves_;
  std::string empty_;  ///< the first product without a shape
  double scale_ = 1;   ///< from the kernel's millimetres to those that the user says
  CadModel model_;
};

/// The kernel prints what it meets; what matters is said in sentences of ours.
void silence() {
  const Handle(Message_Messenger)& messenger = Message::DefaultMessenger();
  messenger->RemovePrinters(STANDARD_TYPE(Message_Printer));
}

class OcctReader final : public CadReader {
 public:
  CadModel read(const std::filesystem::path& file, const CadReadSettings& settings) override {
    static std::mutex one_at_a_time;  // the kernel's session and application are global
    const std::scoped_lock lock(one_at_a_time);
    silence();
    try {
      return StepFile(file, settings).read();
    } catch (const Standard_Failure& failure) {
      if (settings.stop.stop_requested()) throw Interrupted();
      throw InputError(file.string() + ": OpenCASCADE failed: " + failure.GetMessageString());
    }
  }
};

}  // namespace

}  // namespace orasp

extern "C" __attribute__((visibility("default"))) orasp::CadReader* orasp_make_cad_reader_1() {
  return new orasp::OcctReader();
}
