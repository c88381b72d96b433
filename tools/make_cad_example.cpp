// Draws the product of examples/cad and writes it as STEP and as OBJ:
//
//   g++ -std=c++20 -isystem /usr/include/opencascade tools/make_cad_example.cpp -o /tmp/make \
//       -lTKXDESTEP -lTKXCAF -lTKLCAF -lTKCAF -lTKCDF -lTKSTEP -lTKXSBase -lTKMesh -lTKPrim -lTKBO \
//       -lTKTopAlgo -lTKBRep -lTKGeomBase -lTKG3d -lTKMath -lTKernel
//   /tmp/make examples/cad [FOLDER FOR A STEP FILE WITH ONE FILE A PART]
//
// The product is a sensor in a box of 60 x 40 x 24 mm: housing, board, battery, gasket, lid, and
// four screws, which cut their thread into the housing.

#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRep_Tool.hxx>
#include <Interface_Static.hxx>
#include <Poly_Triangulation.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Shape.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_MaterialTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <gp_Trsf.hxx>

namespace {

TopoDS_Shape box(double x, double y, double z, double dx, double dy, double dz) {
  return BRepPrimAPI_MakeBox(gp_Pnt(x, y, z), dx, dy, dz).Shape();
}

TopoDS_Shape cylinder(double x, double y, double z, double radius, double height) {
  return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(x, y, z), gp_Dir(0, 0, 1)), radius, height).Shape();
}

TopoDS_Shape cut(const TopoDS_Shape& from, const TopoDS_Shape& what) {
  return BRepAlgoAPI_Cut(from, what).Shape();
}

TopoDS_Shape fused(const TopoDS_Shape& a, const TopoDS_Shape& b) {
  return BRepAlgoAPI_Fuse(a, b).Shape();
}

constexpr std::array<std::array<double, 2>, 4> kScrews = {{{6, 6}, {54, 6}, {6, 34}, {54, 34}}};

TopoDS_Shape housing() {
  TopoDS_Shape shape = cut(box(0, 0, 0, 60, 40, 20), box(3, 3, 3, 54, 34, 17));
  for (const auto& [x, y] : kScrews) {
    const double left = x < 30 ? 3 : 50;
    const double front = y < 20 ? 3 : 30;
    shape = fused(shape, box(left, front, 3, 7, 7, 17));
  }
  for (const auto& [x, y] : kScrews) shape = cut(shape, cylinder(x, y, 8, 1.25, 12));
  return shape;
}

TopoDS_Shape plate(double z, double thickness, double hole) {
  TopoDS_Shape shape = box(0, 0, z, 60, 40, thickness);
  for (const auto& [x, y] : kScrews) shape = cut(shape, cylinder(x, y, z, hole, thickness));
  return shape;
}

TopoDS_Shape screw() {
  const TopoDS_Shape head = cut(cylinder(0, 0, 0, 2.75, 2.4), cylinder(0, 0, 1.2, 1.2, 1.2));
  return fused(head, cylinder(0, 0, -10, 1.5, 10));
}

struct Product {
  const char* name;
  TopoDS_Shape shape;
  std::array<double, 3> colour;  ///< linear
  const char* material;
  double density;  ///< g/mm^3, as the kernel has it
  std::vector<gp_Vec> places;
};

std::vector<Product> products() {
  const gp_Vec here(0, 0, 0);
  std::vector<gp_Vec> screws;
  for (const auto& [x, y] : kScrews) screws.emplace_back(x, y, 24);
  return {
      {"housing", housing(), {0.25, 0.30, 0.36}, "aluminium", 0.0027, {here}},
      {"board", box(10, 3, 3, 40, 34, 1.6), {0.02, 0.25, 0.10}, "FR4", 0.00185, {here}},
      {"battery", box(20, 10, 4.6, 20, 20, 8), {0.80, 0.35, 0.05}, "lithium cell", 0.0024, {here}},
      {"gasket",
       cut(plate(20, 1, 1.7), box(10, 10, 20, 40, 20, 1)),
       {0.02, 0.02, 0.02},
       "silicone",
       0.00115,
       {here}},
      {"lid", plate(21, 3, 1.7), {0.45, 0.50, 0.55}, "aluminium", 0.0027, {here}},
      {"screw M3x10", screw(), {0.55, 0.55, 0.55}, "", 0, screws},
  };
}

void write_obj(const std::vector<Product>& all, const std::string& file) {
  std::FILE* const out = std::fopen(file.c_str(), "w");
  std::fputs(
      "# A sensor in a box, in millimetres: one object a part. Made by "
      "tools/make_cad_example.cpp.\n",
      out);
  int first = 1;
  for (const Product& product : all) {
    BRepMesh_IncrementalMesh(product.shape, 0.05, Standard_False, 0.5);
    int number = 0;
    for (const gp_Vec& place : product.places) {
      std::fprintf(out, "o %s", product.name);
      std::fprintf(out, ++number > 1 ? " %d\n" : "\n", number);
      for (TopExp_Explorer at(product.shape, TopAbs_FACE); at.More(); at.Next()) {
        TopLoc_Location location;
        const auto mesh = BRep_Tool::Triangulation(TopoDS::Face(at.Current()), location);
        for (int i = 1; i <= mesh->NbNodes(); ++i) {
          const gp_Pnt p = mesh->Node(i).Transformed(location.Transformation()).Translated(place);
          std::fprintf(out, "v %.6g %.6g %.6g\n", p.X() + 0.0, p.Y() + 0.0, p.Z() + 0.0);
        }
        for (int i = 1; i <= mesh->NbTriangles(); ++i) {
          int a = 0;
          int b = 0;
          int c = 0;
          mesh->Triangle(i).Get(a, b, c);
          if (at.Current().Orientation() == TopAbs_REVERSED) std::swap(b, c);
          std::fprintf(out, "f %d %d %d\n", first + a - 1, first + b - 1, first + c - 1);
        }
        first += mesh->NbNodes();
      }
    }
  }
  std::fclose(out);
}

Handle(TDocStd_Document) document_of(const std::vector<Product>& all) {
  Handle(TDocStd_Document) document;
  XCAFApp_Application::GetApplication()->NewDocument("BinXCAF", document);
  const auto shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  const auto colours = XCAFDoc_DocumentTool::ColorTool(document->Main());
  const auto materials = XCAFDoc_DocumentTool::MaterialTool(document->Main());
  const TDF_Label whole = shapes->NewShape();
  TDataStd_Name::Set(whole, "sensor box");
  const TDF_Label cover = shapes->NewShape();
  TDataStd_Name::Set(cover, "cover");
  for (const Product& product : all) {
    const TDF_Label label = shapes->AddShape(product.shape, Standard_False);
    TDataStd_Name::Set(label, product.name);
    const auto& [r, g, b] = product.colour;
    colours->SetColor(label, Quantity_Color(r, g, b, Quantity_TOC_RGB), XCAFDoc_ColorSurf);
    if (product.density > 0) {
      materials->SetMaterial(label, new TCollection_HAsciiString(product.material),
                             new TCollection_HAsciiString(""), product.density,
                             new TCollection_HAsciiString("density measure"),
                             new TCollection_HAsciiString("POSITIVE_RATIO_MEASURE"));
    }
    // Lid and gasket are an assembly of their own inside of the product.
    const std::string name = product.name;
    for (const gp_Vec& place : product.places) {
      gp_Trsf where;
      where.SetTranslation(place);
      shapes->AddComponent(name == "lid" || name == "gasket" ? cover : whole, label, where);
    }
  }
  shapes->AddComponent(whole, cover, TopLoc_Location());
  shapes->UpdateAssemblies();
  return document;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 30;
  const std::vector<Product> all = products();
  const std::string folder = argv[1];
  STEPCAFControl_Writer writer;
  Interface_Static::SetCVal("write.step.schema", "AP214IS");
  if (!writer.Transfer(document_of(all), STEPControl_AsIs)) return 40;
  if (writer.Write((folder + "/sensor_box.step").c_str()) != IFSelect_RetDone) return 40;
  write_obj(all, folder + "/sensor_box.obj");
  if (argc < 3) return 0;
  STEPCAFControl_Writer parts;
  if (!parts.Transfer(document_of(all), STEPControl_AsIs, "part_")) return 40;
  const std::string main_file = std::string(argv[2]) + "/references.step";
  return parts.Write(main_file.c_str()) == IFSelect_RetDone ? 0 : 40;
}
