#!/usr/bin/env python3
"""VTK's own readers and writers, for tests/unit/test_vtk.c.

vtk-check.py copy FROM TO  read a mesh and write what VTK has understood as VTP; strings of field data go to stdout
vtk-check.py write FOLDER  a sphere of strips and polygons, with point, cell and field data, in every form that VTK's writers know
Needs python3-vtk9; exit status 77 where it is not installed.
"""
import sys

try:
    import vtk
except ImportError:
    sys.exit(77)


def read(path):
    with open(path, "rb") as file:
        start = file.read(64)
    reader = (
        vtk.vtkPLYReader() if start.startswith(b"ply")
        else vtk.vtkSTLReader() if path.endswith(".stl")
        else vtk.vtkXMLPolyDataReader() if b"<" in start
        else vtk.vtkPolyDataReader()
    )
    reader.SetFileName(path)
    reader.Update()
    if reader.GetErrorCode():
        sys.exit(f"{path}: VTK cannot read it")
    return reader.GetOutput()


def copy(source, target):
    mesh = read(source)
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetInputData(mesh)
    writer.SetFileName(target)
    writer.Write()
    field = mesh.GetFieldData()
    for i in range(field.GetNumberOfArrays()):
        strings = field.GetAbstractArray(i)
        if strings.IsA("vtkStringArray"):
            print(strings.GetName(), *(strings.GetValue(k) for k in range(strings.GetNumberOfValues())))


def add(data, name, count, components, make, kind=vtk.vtkFloatArray):
    array = kind()
    array.SetName(name)
    array.SetNumberOfComponents(components)
    array.SetNumberOfTuples(count)
    for i in range(count):
        for c in range(components):
            array.SetComponent(i, c, make(i, c))
    data.AddArray(array)
    return array


def sample():
    sphere = vtk.vtkSphereSource()
    sphere.SetThetaResolution(12)
    sphere.SetPhiResolution(9)
    stripper = vtk.vtkStripper()
    stripper.SetInputConnection(sphere.GetOutputPort())
    stripper.SetMaximumLength(7)
    stripper.Update()
    mesh = vtk.vtkPolyData()
    mesh.DeepCopy(stripper.GetOutput())
    polygons = vtk.vtkCellArray()
    for cell in ((0, 2, 3), (2, 9, 10, 3), (4, 5, 12)):
        polygons.InsertNextCell(len(cell))
        for point in cell:
            polygons.InsertCellPoint(point)
    mesh.SetPolys(polygons)
    marks = vtk.vtkCellArray()
    marks.InsertNextCell(1)
    marks.InsertCellPoint(0)
    mesh.SetVerts(marks)
    points, cells, data = mesh.GetNumberOfPoints(), mesh.GetNumberOfCells(), mesh.GetPointData()
    data.SetScalars(add(data, "activation share", points, 1, lambda i, c: i / 7, vtk.vtkDoubleArray))
    data.SetVectors(add(data, "fiber", points, 3, lambda i, c: i + c / 4))
    add(data, "part", points, 1, lambda i, c: i % 5, vtk.vtkUnsignedCharArray)
    add(data, "number", points, 1, lambda i, c: 1000 * i - 500, vtk.vtkIdTypeArray)
    add(data, "wide", points, 5, lambda i, c: i - c, vtk.vtkShortArray)
    add(mesh.GetCellData(), "cell number", cells, 1, lambda i, c: i, vtk.vtkIntArray)
    mesh.GetCellData().SetScalars(add(mesh.GetCellData(), "rgb", cells, 3, lambda i, c: i + c, vtk.vtkUnsignedCharArray))
    words = vtk.vtkStringArray()
    words.SetName("who made it")
    for word in ("POINTS 3 float", "", "a longer line " * 9):
        words.InsertNextValue(word)
    mesh.GetFieldData().AddArray(words)
    for array in (data.GetArray("fiber"), mesh.GetPoints().GetData()):
        array.GetRange(-1)  # notes on the norm become METADATA and InformationKey
        array.SetComponentName(0, "along x")
    return mesh


def write(folder):
    mesh = sample()
    for binary in (False, True):
        for version in (42, 51):
            writer = vtk.vtkPolyDataWriter()
            writer.SetInputData(mesh)
            writer.SetFileVersion(version)
            writer.SetFileType(2 if binary else 1)
            writer.SetFileName(f"{folder}/{'binary' if binary else 'ascii'}-{version}.vtk")
            writer.Write()
    for mode in ("Ascii", "Binary", "Appended"):
        for packed in ("zlib", "plain", "lz4"):
            for order in ("little", "big"):
                for width in (32, 64):
                    for encoded in ((True, False) if mode == "Appended" else (True,)):
                        writer = vtk.vtkXMLPolyDataWriter()
                        writer.SetInputData(mesh)
                        getattr(writer, f"SetDataModeTo{mode}")()
                        writer.SetBlockSize(512)
                        writer.SetHeaderType(width)
                        writer.SetEncodeAppendedData(encoded)
                        writer.SetByteOrder(1 if order == "little" else 0)
                        if packed == "plain":
                            writer.SetCompressorTypeToNone()
                        elif packed == "lz4":
                            writer.SetCompressorTypeToLZ4()
                        else:
                            writer.SetCompressorTypeToZLib()
                        writer.SetNumberOfPieces(2 if width == 64 else 1)
                        form = "base64" if encoded else "raw"
                        writer.SetFileName(f"{folder}/{mode.lower()}-{packed}-{order}-{width}-{form}.vtp")
                        writer.Write()


if sys.argv[1] == "copy":
    copy(*sys.argv[2:4])
else:
    write(sys.argv[2])
