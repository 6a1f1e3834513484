//! Which primitives a scene shows, where their data is, and what is said of them.

use super::GlbError;
use super::columns::{Column, Component, Data};
use super::container::GlbFile;
use super::document::{Accessor, Document, Primitive, one_line};
use super::packed::Packing;
use super::transform::Transform;
use crate::base::CoordinateFrame;
use crate::base::channels::{Channel, Number};
use crate::formats::{Header, lines};

/// The most primitives of a scene; terrabite's files of 4 GiB have a tenth.
const PARTS: usize = 1 << 17;

/// The most bytes from one element to the next; glTF allows 252, compressed views 256.
const STRIDE: u64 = 256;

/// What a scene is made of.
#[derive(Debug)]
pub(super) struct Scene {
    pub(super) parts: Vec<Part>,
    pub(super) header: Header,
    /// What the vertices of all parts have.
    pub(super) attributes: Vec<Channel>,
}

/// A primitive at a place.
#[derive(Debug)]
pub(super) struct Part {
    mesh: usize,
    primitive: usize,
    /// Vertices of the parts before it.
    pub(super) first: u64,
    pub(super) vertices: u64,
    pub(super) faces: u64,
    pub(super) positions: Column,
    /// `None`: three vertices in a row are a triangle.
    pub(super) indices: Option<Column>,
    /// In the order of [`Scene::attributes`].
    pub(super) fields: Vec<Field>,
    /// What is to be done to positions, y up; nothing where the frame says it.
    pub(super) transform: Transform,
}

/// Where the values of an attribute are.
#[derive(Debug, Clone)]
pub(super) struct Field {
    name: String,
    pub(super) column: Column,
    pub(super) component: usize,
    pub(super) is_negated: bool,
}

impl Part {
    /// What messages call it.
    pub(super) fn name(&self) -> String {
        name(self.mesh, self.primitive)
    }
}

fn name(mesh: usize, primitive: usize) -> String {
    format!("mesh {mesh}, primitive {primitive}")
}

/// Extensions without which a mesh can be understood: they say how it looks.
const LOOKS: [&str; 5] = ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_xmp"];

/// Extensions that are read, or noticed where they are used.
const READ: [&str; 3] = ["EXT_meshopt_compression", "KHR_meshopt_compression", "KHR_mesh_quantization"];

/// The scene of a document.
///
/// # Errors
/// [`GlbError`] if it is damaged, or needs what is not read.
pub(super) fn scene(glb: &GlbFile, document: &Document) -> Result<Scene, GlbError> {
    let builder = Builder { glb, document };
    if !document.asset.version.starts_with("2.") {
        return Err(builder.unfit("asset", "version 2", &document.asset.version));
    }
    let is_fine = |name: &str| READ.contains(&name) || LOOKS.iter().any(|looks| name.starts_with(looks));
    if let Some(name) = document.extensions_required.iter().find(|name| !is_fine(name)) {
        return Err(builder.extension("extensionsRequired", name));
    }
    let mut parts = builder.parts()?;
    let header = header(document, &mut parts);
    if parts.iter().any(|part| part.transform.as_way().is_none()) {
        // They would have to be turned with the mesh.
        let is_normal = |name: &str| ["nx", "ny", "nz"].contains(&name);
        parts.iter_mut().for_each(|part| part.fields.retain(|field| !is_normal(&field.name)));
    }
    let attributes = attributes(document, &mut parts);
    Ok(Scene { parts, header, attributes })
}

/// What the file says, with the frame in which coordinates are read; clears the transformations that it stands for.
fn header(document: &Document, parts: &mut [Part]) -> Header {
    let facts = document.asset.facts();
    let mut header = match &facts {
        Some(facts) => lines::header(facts.iter().map(String::as_str)),
        None => Header { made_by: document.asset.generator.as_deref().map(one_line), ..Header::default() },
    };
    let (frame, plain) = (header.frame, CoordinateFrame::PLAIN);
    let said = (frame.origin.0 * frame.xy_scale.0, frame.origin.1 * frame.xy_scale.1);
    header.frame = match (way(parts), facts.is_some()) {
        (Some([x, 0.0, z]), true) if (x, -z) == said => CoordinateFrame { single: true, ..frame },
        // Zeros without a sign.
        (Some([x, 0.0, z]), false) => CoordinateFrame { origin: (x + 0.0, 0.0 - z), single: true, ..plain },
        (None, _) if parts.is_empty() => CoordinateFrame { single: true, ..frame },
        // Another program has moved the mesh: gltfpack adds the origin to the positions, and keeps what terrabite said.
        _ => {
            let single = parts.iter().all(|part| part.transform == Transform::NONE);
            header.frame = CoordinateFrame { origin: plain.origin, single, ..frame };
            return header;
        }
    };
    parts.iter_mut().for_each(|part| part.transform = Transform::NONE);
    header
}

/// By what all parts are moved, if that is all that is done to them.
fn way(parts: &[Part]) -> Option<[f64; 3]> {
    let way = parts.first()?.transform.as_way()?;
    parts.iter().all(|part| part.transform.as_way() == Some(way)).then_some(way)
}

/// What all parts have, in the order of the first; parts keep nothing else.
fn attributes(document: &Document, parts: &mut [Part]) -> Vec<Channel> {
    let order = document.asset.attributes();
    let Some((first, others)) = parts.split_first_mut() else { return Vec::new() };
    let find = |part: &Part, name: &str| part.fields.iter().find(|field| field.name == name).cloned();
    first.fields.retain(|field| others.iter().all(|part| find(part, &field.name).is_some()));
    first.fields.sort_by_key(|field| order.iter().position(|name| *name == field.name).unwrap_or(usize::MAX));
    let names: Vec<String> = first.fields.iter().map(|field| field.name.clone()).collect();
    for part in others {
        part.fields = names.iter().filter_map(|name| find(part, name)).collect();
    }
    let widest = |i: usize| {
        let numbers = parts.iter().map(|part| part.fields[i].column.component.number());
        numbers.max_by_key(|number| *number as u8).unwrap_or(Number::F32)
    };
    names.iter().enumerate().map(|(i, name)| Channel { name: name.clone(), number: widest(i) }).collect()
}

struct Builder<'a> {
    glb: &'a GlbFile,
    document: &'a Document,
}

impl Builder<'_> {
    fn unfit(&self, place: impl ToString, expected: impl ToString, found: impl ToString) -> GlbError {
        GlbError::Document {
            path: self.glb.path.clone(),
            place: place.to_string(),
            expected: expected.to_string(),
            found: found.to_string(),
        }
    }

    fn extension(&self, place: impl ToString, name: &str) -> GlbError {
        GlbError::Extension { path: self.glb.path.clone(), place: place.to_string(), name: name.to_string() }
    }

    /// The part of a list that something names.
    fn get<'l, T>(
        &self,
        list: &'l [T],
        index: usize,
        what: &str,
        place: &dyn Fn() -> String,
    ) -> Result<&'l T, GlbError> {
        list.get(index).ok_or_else(|| {
            self.unfit(place(), format!("one of {} {what}, counted from 0", list.len()), format!("number {index}"))
        })
    }

    fn roots(&self) -> Result<Vec<usize>, GlbError> {
        let Document { scene, scenes, nodes, .. } = self.document;
        if scenes.is_empty() {
            let mut is_child = vec![false; nodes.len()];
            let children = nodes.iter().flat_map(|node| &node.children);
            children.for_each(|child| is_child.iter_mut().skip(*child).take(1).for_each(|is_child| *is_child = true));
            return Ok((0..nodes.len()).filter(|node| !is_child[*node]).collect());
        }
        Ok(self.get(scenes, scene.unwrap_or(0), "scenes", &|| "scene".to_string())?.nodes.clone())
    }

    /// The primitives of the scene, nodes before their children.
    fn parts(&self) -> Result<Vec<Part>, GlbError> {
        let nodes = &self.document.nodes;
        let mut parts = Vec::new();
        let mut seen = vec![false; nodes.len()];
        let mut waiting: Vec<(usize, Transform)> = self.roots()?.into_iter().map(|n| (n, Transform::NONE)).collect();
        waiting.reverse();
        while let Some((index, outer)) = waiting.pop() {
            self.glb.cancel.check()?;
            let place = || format!("node {index}");
            let node = self.get(nodes, index, "nodes", &place)?;
            if std::mem::replace(&mut seen[index], true) {
                return Err(self.unfit(place(), "a node that one other has, or a scene", "more of them"));
            }
            let inner = Transform::of(node);
            let inner = inner.ok_or_else(|| self.unfit(place(), "a matrix whose last row is 0 0 0 1", "another"))?;
            let transform = outer.after(&inner);
            if let Some(mesh) = node.mesh {
                if node.skin.is_some() {
                    return Err(self.unfit(place(), "a mesh at rest", "a skin"));
                }
                self.mesh(mesh, transform, &place, &mut parts)?;
            }
            waiting.extend(node.children.iter().rev().map(|child| (*child, transform)));
        }
        Ok(parts)
    }

    fn mesh(
        &self,
        mesh: usize,
        transform: Transform,
        place: &dyn Fn() -> String,
        parts: &mut Vec<Part>,
    ) -> Result<(), GlbError> {
        for (i, primitive) in self.get(&self.document.meshes, mesh, "meshes", place)?.primitives.iter().enumerate() {
            if parts.len() == PARTS {
                return Err(self.unfit("scene", format!("at most {PARTS} primitives"), "more"));
            }
            let mut part = self.part(primitive, mesh, i)?;
            part.first = parts.last().map_or(0, |before: &Part| before.first + before.vertices);
            part.transform = transform;
            parts.push(part);
        }
        Ok(())
    }

    fn part(&self, primitive: &Primitive, mesh: usize, number: usize) -> Result<Part, GlbError> {
        let place = || name(mesh, number);
        let draco = "KHR_draco_mesh_compression";
        if primitive.extensions.contains_key(draco) {
            return Err(self.extension(place(), draco));
        }
        if primitive.mode.is_some_and(|mode| mode != 4) {
            return Err(self.unfit(place(), "triangles (mode 4)", format!("mode {}", primitive.mode.unwrap_or(4))));
        }
        let position = primitive.attributes.get("POSITION");
        let position = *position.ok_or_else(|| self.unfit(place(), "positions (POSITION)", "none"))?;
        let positions = self.column(position, &place)?;
        if positions.components != 3 || positions.component != Component::F32 {
            return Err(match positions.components {
                3 => self.extension(place(), "KHR_mesh_quantization"),
                found => self.unfit(place(), "positions of three numbers", found),
            });
        }
        let indices = primitive.indices.map(|accessor| self.column(accessor, &place)).transpose()?;
        if let Some(indices) = &indices
            && (indices.components != 1
                || !matches!(indices.component, Component::U8 | Component::U16 | Component::U32))
        {
            return Err(self.unfit(place(), "indices that are single numbers without a sign", "others"));
        }
        let corners = indices.as_ref().map_or(positions.count, |indices| indices.count);
        if !corners.is_multiple_of(3) {
            return Err(self.unfit(place(), "three corners for each triangle", format!("{corners} corners")));
        }
        Ok(Part {
            mesh,
            primitive: number,
            first: 0,
            vertices: positions.count,
            faces: corners / 3,
            positions,
            indices,
            fields: self.fields(primitive, positions.count, &place)?,
            transform: Transform::NONE,
        })
    }

    /// What vertices have beside their positions, in the order of the accessors.
    fn fields(&self, primitive: &Primitive, count: u64, place: &dyn Fn() -> String) -> Result<Vec<Field>, GlbError> {
        let mut accessors: Vec<(usize, &str)> = primitive.attributes.iter().map(|(s, a)| (*a, s.as_str())).collect();
        accessors.sort_unstable();
        let mut fields: Vec<Field> = Vec::new();
        for (accessor, semantic) in accessors {
            let names: &[(&str, usize, bool)] = match semantic {
                "NORMAL" => &[("nx", 0, false), ("ny", 2, true), ("nz", 1, false)],
                "COLOR_0" => &[("red", 0, false), ("green", 1, false), ("blue", 2, false)],
                _ => match semantic.strip_prefix('_') {
                    Some(name) if is_word(name) => &[(name, 0, false)],
                    _ => continue,
                },
            };
            let kind = self.get(&self.document.accessors, accessor, "accessors", place)?;
            let is_ours = match semantic {
                "NORMAL" => kind.kind == "VEC3" && kind.component_type == 5126,
                "COLOR_0" => ["VEC3", "VEC4"].contains(&kind.kind.as_str()),
                _ => kind.kind == "SCALAR",
            };
            if !is_ours {
                continue;
            }
            let column = self.column(accessor, place)?;
            if column.count != count {
                let found = format!("{} of {semantic}", column.count);
                return Err(self.unfit(place(), format!("as many as there are positions, {count}"), found));
            }
            let new = names.iter().filter(|(name, ..)| !fields.iter().any(|f| f.name == *name));
            let new = new.map(|&(name, component, is_negated)| Field {
                name: name.to_string(),
                column,
                component,
                is_negated,
            });
            let new: Vec<Field> = new.collect();
            fields.extend(new);
        }
        Ok(fields)
    }

    /// Where the elements of an accessor are: all of them in the file.
    fn column(&self, index: usize, user: &dyn Fn() -> String) -> Result<Column, GlbError> {
        let accessor = self.get(&self.document.accessors, index, "accessors", user)?;
        let Accessor { byte_offset: offset, count, .. } = *accessor;
        let place = || format!("accessor {index}");
        if accessor.sparse.is_some() {
            return Err(self.unfit(place(), "an accessor that is not sparse", "a sparse one"));
        }
        let component = Component::of(accessor.component_type);
        let component = component.ok_or_else(|| self.unfit(place(), "a component type", accessor.component_type))?;
        let components = ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|kind| *kind == accessor.kind);
        let components = components.ok_or_else(|| self.unfit(place(), "SCALAR or a vector", &accessor.kind))? + 1;
        let view = accessor.buffer_view.ok_or_else(|| self.unfit(place(), "a bufferView", "none"))?;
        let (data, length, stride) = self.view(view, &place)?;
        let size = (components * component.bytes()) as u64;
        let stride = stride.unwrap_or(size);
        if !(size..=STRIDE).contains(&stride) {
            let expected = format!("elements {size} to {STRIDE} bytes apart");
            return Err(self.unfit(format!("bufferView {view}"), expected, stride));
        }
        let end = count
            .checked_sub(1)
            .map_or(Some(offset), |last| last.checked_mul(stride)?.checked_add(offset)?.checked_add(size));
        if end.is_none_or(|end| end > length) {
            let expected = format!("elements within the {length} bytes of bufferView {view}");
            return Err(self.unfit(place(), expected, format!("{count} of {stride} bytes from byte {offset} on")));
        }
        Ok(Column { view, data, length, offset, stride: stride as usize, count, component, components })
    }

    /// Where the bytes of a view are, how many, and how far its elements are apart where it says so.
    fn view(&self, index: usize, user: &dyn Fn() -> String) -> Result<(Data, u64, Option<u64>), GlbError> {
        let view = self.get(&self.document.buffer_views, index, "bufferViews", user)?;
        let place = || format!("bufferView {index}");
        let data = match view.packed() {
            None => Data::Plain { start: self.bin(view.buffer, view.byte_offset, view.byte_length, &place)? },
            Some(packed) => {
                let start = self.bin(packed.buffer, packed.byte_offset, packed.byte_length, &place)?;
                let packing = Packing::new(packed, start, view.byte_length);
                Data::Packed(packing.map_err(|(expected, found)| self.unfit(place(), expected, found))?)
            }
        };
        Ok((data, view.byte_length, view.byte_stride))
    }

    /// Where a stretch of a buffer begins in the file.
    fn bin(&self, buffer: usize, offset: u64, length: u64, place: &dyn Fn() -> String) -> Result<u64, GlbError> {
        let found = self.get(&self.document.buffers, buffer, "buffers", place)?;
        let name = || format!("buffer {buffer}");
        if let Some(uri) = &found.uri {
            let uri: String = uri.chars().take(40).collect();
            return Err(self.unfit(name(), "its data in the BIN chunk of this file", format!("the address {uri:?}")));
        }
        let (start, bytes) = match self.glb.bin {
            Some(bin) if buffer == 0 => bin,
            _ => return Err(self.unfit(name(), "its data in the BIN chunk", "none")),
        };
        if found.byte_length > bytes {
            let expected = format!("at most {bytes} bytes, those of the BIN chunk");
            return Err(self.unfit(name(), expected, found.byte_length));
        }
        match offset.checked_add(length).is_some_and(|end| end <= found.byte_length) {
            true => Ok(start + offset),
            false => {
                let expected = format!("bytes within the {} of buffer {buffer}", found.byte_length);
                Err(self.unfit(place(), expected, format!("{length} from byte {offset} on")))
            }
        }
    }
}

/// Whether an attribute can be called so.
fn is_word(name: &str) -> bool {
    let is_coordinate = ["x", "y", "z"].contains(&name);
    !name.is_empty() && !is_coordinate && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}
