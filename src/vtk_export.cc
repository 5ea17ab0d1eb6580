#include "vtk_export.h"

extern "C" {
#include "error.h"
#include "stream_private.h"
}

#include <cstring>
#include <exception>
#include <new>
#include <string>

#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkIntArray.h>
#include <vtkMeshQuality.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

namespace {

// Takes VTK's messages in place of standard error.
class quiet_window : public vtkOutputWindow {
public:
    static quiet_window *New();
    vtkTypeMacro(quiet_window, vtkOutputWindow)
    void DisplayText(const char *text) override
    {
        if (message.empty() && text)
            message = text;
    }
    std::string message;
};
vtkStandardNewMacro(quiet_window)

vtkSmartPointer<vtkDataArray> new_array(enum vtk_type type)
{
    switch (type) {
    case VTK_EXPORT_F32:
        return vtkSmartPointer<vtkFloatArray>::New();
    case VTK_EXPORT_F64:
        return vtkSmartPointer<vtkDoubleArray>::New();
    case VTK_EXPORT_I32:
        return vtkSmartPointer<vtkIntArray>::New();
    case VTK_EXPORT_U8:
        break;
    }
    return vtkSmartPointer<vtkUnsignedCharArray>::New();
}

void add_arrays(vtkFieldData *to, const struct vtk_array *arrays, size_t array_count, size_t tuples)
{
    for (size_t i = 0; i < array_count; i++) {
        const struct vtk_array &from = arrays[i];
        vtkSmartPointer<vtkDataArray> array = new_array(from.type);
        array->SetName(from.name);
        array->SetNumberOfComponents(static_cast<int>(from.width));
        array->SetNumberOfTuples(static_cast<vtkIdType>(tuples));
        for (size_t k = 0; from.components && k < from.width; k++)
            array->SetComponentName(static_cast<vtkIdType>(k), from.components[k]);
        const size_t bytes = tuples * from.width * static_cast<size_t>(array->GetDataTypeSize());
        if (bytes)
            std::memcpy(array->GetVoidPointer(0), from.data, bytes);
        to->AddArray(array);
    }
}

vtkSmartPointer<vtkPoints> make_points(const struct vtk_mesh *mesh)
{
    auto points = vtkSmartPointer<vtkPoints>::New();
    points->SetDataTypeToDouble();
    points->SetNumberOfPoints(static_cast<vtkIdType>(mesh->point_count));
    if (mesh->point_count)
        std::memcpy(points->GetVoidPointer(0), mesh->position, 3 * mesh->point_count * sizeof(double));
    return points;
}

vtkSmartPointer<vtkCellArray> make_cells(const struct vtk_mesh *mesh, size_t corners)
{
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    const size_t count = mesh->cell_count ? mesh->cell_count : mesh->point_count, size = mesh->cell_count ? corners : 1;
    vtkNew<vtkIdTypeArray> connectivity;
    connectivity->SetNumberOfValues(static_cast<vtkIdType>(count * size));
    for (size_t i = 0; i < count * size; i++)
        connectivity->SetValue(static_cast<vtkIdType>(i), mesh->cell_count ? mesh->vertex[i] : static_cast<vtkIdType>(i));
    cells->SetData(static_cast<vtkIdType>(size), connectivity);
    return cells;
}

void add_all(vtkDataSet *data, const struct vtk_mesh *mesh)
{
    add_arrays(data->GetPointData(), mesh->point_arrays, mesh->point_array_count, mesh->point_count);
    if (mesh->cell_count)
        add_arrays(data->GetCellData(), mesh->cell_arrays, mesh->cell_array_count, mesh->cell_count);
    for (size_t i = 0; i < mesh->text_count; i++) {
        vtkNew<vtkStringArray> text;
        text->SetName(mesh->texts[i].name);
        text->InsertNextValue(mesh->texts[i].value);
        data->GetFieldData()->AddArray(text);
    }
}

void add_quality(vtkUnstructuredGrid *grid, const char *name, int measure)
{
    vtkNew<vtkMeshQuality> quality;
    quality->SetInputData(grid);
    quality->SetTetQualityMeasure(measure);
    quality->Update();
    vtkDataArray *result = quality->GetOutput()->GetCellData()->GetArray("Quality");
    if (!result)
        return;
    auto array = vtkSmartPointer<vtkDataArray>::Take(result->NewInstance());
    array->DeepCopy(result);
    array->SetName(name);
    grid->GetCellData()->AddArray(array);
}

struct error *write_bytes(const char *path, const std::string &bytes)
{
    struct stream_output out;
    struct error *err = output_open(&out, path, false);
    if (err)
        return err;
    char *room;
    err = output_room(&out, bytes.size(), &room);
    if (err) {
        output_abandon(&out);
        return err;
    }
    std::memcpy(room, bytes.data(), bytes.size());
    out.count += bytes.size();
    return output_finish(&out);
}

struct error *write(vtkXMLWriter *writer, vtkDataSet *data, const char *path, int ascii)
{
    writer->SetInputDataObject(data);
    writer->WriteToOutputStringOn();
    writer->SetCompressorType(vtkXMLWriter::NONE);
    if (ascii)
        writer->SetDataModeToAscii();
    else
        writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
    if (!writer->Write() || writer->GetErrorCode()) {
        auto *window = quiet_window::SafeDownCast(vtkOutputWindow::GetInstance());
        return error_new("%s: VTK could not write the mesh: %.200s", path, window ? window->message.c_str() : "");
    }
    return write_bytes(path, writer->GetOutputString());
}

// Runs f with VTK's messages taken in, and turns exceptions into errors.
template <class Function> struct error *guard(const Function &f) noexcept
{
    try {
        vtkNew<quiet_window> window;
        vtkOutputWindow::SetInstance(window);
        struct error *err = f();
        vtkOutputWindow::SetInstance(nullptr);
        return err;
    } catch (const std::bad_alloc &) {
        return error_memory();
    } catch (const std::exception &e) {
        return error_new("VTK: %s", e.what());
    } catch (...) {
        return error_new("VTK threw an unknown exception");
    }
}

} // namespace

extern "C" struct error *vtk_write_grid(const char *path, const struct vtk_mesh *mesh, int ascii)
{
    return guard([=] {
        vtkNew<vtkUnstructuredGrid> grid;
        grid->SetPoints(make_points(mesh));
        grid->SetCells(mesh->cell_count ? VTK_TETRA : VTK_VERTEX, make_cells(mesh, 4));
        if (mesh->cell_count) {
            add_quality(grid, "min_dihedral", VTK_QUALITY_MIN_ANGLE);
            add_quality(grid, "aspect_ratio", VTK_QUALITY_ASPECT_RATIO);
            add_quality(grid, "volume", VTK_QUALITY_VOLUME);
        }
        add_all(grid, mesh);
        vtkNew<vtkXMLUnstructuredGridWriter> writer;
        return write(writer, grid, path, ascii);
    });
}

extern "C" struct error *vtk_write_surface(const char *path, const struct vtk_mesh *mesh, int ascii)
{
    return guard([=] {
        vtkNew<vtkPolyData> surface;
        surface->SetPoints(make_points(mesh));
        surface->SetPolys(make_cells(mesh, 3));
        add_all(surface, mesh);
        vtkNew<vtkXMLPolyDataWriter> writer;
        return write(writer, surface, path, ascii);
    });
}
