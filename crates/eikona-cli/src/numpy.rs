//! NumPy arrays (.npy) and archives of them (.npz).

use npyz::{AutoSerialize, DType, NpyFile, Order, TypeChar, WriteOptions, WriterBuilder};
use std::io::{self, Cursor, Read, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// Numbers with a shape, in row-major order.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    pub shape: Vec<usize>,
    pub values: Vec<f64>,
}

/// Returns an array as the bytes of a `.npy` file.
pub fn npy<T: AutoSerialize + Copy>(shape: &[usize], values: &[T]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(128 + size_of_val(values));
    let shape: Vec<u64> = shape.iter().map(|n| *n as u64).collect();
    let options = WriteOptions::new().default_dtype().shape(&shape);
    let mut writer = options.writer(&mut bytes).begin_nd()?;
    writer.extend(values.iter().copied())?;
    writer.finish()?;
    Ok(bytes)
}

/// Reads the bytes of a `.npy` file of integers or floating-point numbers.
///
/// # Errors
/// A description of what is wrong with the file.
pub fn read_npy(bytes: &[u8]) -> Result<Array, String> {
    let not_npy = |fault: io::Error| format!("not a NumPy array: {fault}");
    let mut rest = bytes;
    let file = NpyFile::new(&mut rest).map_err(not_npy)?;
    let DType::Plain(kind) = file.dtype() else {
        return Err("an array of records; save an array of plain numbers".into());
    };
    if file.order() != Order::C && file.shape().len() > 1 {
        return Err("in Fortran order; save numpy.ascontiguousarray of it".into());
    }
    let shape: Vec<usize> = file.shape().iter().map(|n| *n as usize).collect();
    if shape.iter().try_fold(1usize, |product, n| product.checked_mul(*n)).is_none() {
        return Err(format!("shorter than its header says, which is of shape {shape:?}"));
    }
    let (width, count) = (kind.size_field(), file.len());
    let values = match (kind.type_char(), width) {
        (TypeChar::Float, 8) => file.into_vec::<f64>(),
        (TypeChar::Float, 4) => converted(file.into_vec::<f32>()),
        (TypeChar::Int, 4) => converted(file.into_vec::<i32>()),
        (TypeChar::Uint, 4) => converted(file.into_vec::<u32>()),
        // Exact up to 2^53, beyond any number of elements.
        (TypeChar::Int, 8) => file.into_vec::<i64>().map(|v| v.into_iter().map(|x| x as f64).collect()),
        (TypeChar::Uint, 8) => file.into_vec::<u64>().map(|v| v.into_iter().map(|x| x as f64).collect()),
        _ => return Err(format!("of type {kind}; save an array of type float64 or int64")),
    };
    let values = values.map_err(|_| format!("shorter than its header says, which is {count} numbers"))?;
    if !rest.is_empty() {
        return Err(format!("longer than its header says, which is {count} numbers"));
    }
    Ok(Array { shape, values })
}

fn converted<T: Into<f64>>(values: io::Result<Vec<T>>) -> io::Result<Vec<f64>> {
    values.map(|values| values.into_iter().map(Into::into).collect())
}

/// Arrays by name, in the order in which they are added.
pub struct NpzWriter {
    zip: ZipWriter<Cursor<Vec<u8>>>,
}

impl NpzWriter {
    pub fn new() -> NpzWriter {
        NpzWriter { zip: ZipWriter::new(Cursor::new(Vec::new())) }
    }

    pub fn add<T: AutoSerialize + Copy>(
        &mut self,
        name: &str,
        shape: &[usize],
        values: &[T],
    ) -> io::Result<()> {
        // More than 4 GiB need a wider header.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .large_file(size_of_val(values) as u64 > u64::from(u32::MAX / 2));
        self.zip.start_file(format!("{name}.npy"), options)?;
        self.zip.write_all(&npy(shape, values)?)
    }

    pub fn finish(self) -> io::Result<Vec<u8>> {
        Ok(self.zip.finish()?.into_inner())
    }
}

/// The bytes of a `.npz` file.
pub struct NpzReader<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
}

impl<'a> NpzReader<'a> {
    /// # Errors
    /// A description of what is wrong with the file.
    pub fn new(bytes: &'a [u8]) -> Result<NpzReader<'a>, String> {
        let zip = ZipArchive::new(Cursor::new(bytes));
        Ok(NpzReader { zip: zip.map_err(|fault| format!("not an archive of NumPy arrays: {fault}"))? })
    }

    /// Reads an array of a shape; `None` stands for any number.
    ///
    /// # Errors
    /// A description of what is wrong with the array.
    pub fn array(&mut self, name: &str, shape: &[Option<usize>]) -> Result<Array, String> {
        let wrong = |problem: String| format!("the array {name} is {problem}");
        let file = self.zip.by_name(&format!("{name}.npy"));
        let mut file = file.map_err(|_| wrong("missing".into()))?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(|fault| wrong(format!("damaged: {fault}")))?;
        let array = read_npy(&bytes).map_err(wrong)?;
        let fits = |(found, wanted): (&usize, &Option<usize>)| wanted.is_none_or(|wanted| *found == wanted);
        if array.shape.len() != shape.len() || !array.shape.iter().zip(shape).all(fits) {
            return Err(wrong(format!("of shape {:?}, which is not that of a field", array.shape)));
        }
        Ok(array)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_survive() {
        let values = [0.1, -3.0, f64::MIN_POSITIVE, 1e300, 0.0, 7.0];
        let read = read_npy(&npy(&[2, 3], &values).unwrap()).unwrap();
        assert_eq!(read, Array { shape: vec![2, 3], values: values.to_vec() });
        for bytes in [npy(&[3], &[1i32, 2, -3]), npy(&[3], &[1i64, 2, -3]), npy(&[3], &[1f32, 2.0, -3.0])] {
            assert_eq!(read_npy(&bytes.unwrap()).unwrap().values, [1.0, 2.0, -3.0]);
        }
        assert_eq!(
            read_npy(&npy(&[], &[5u32]).unwrap()).unwrap(),
            Array { shape: vec![], values: vec![5.0] }
        );
        let mut writer = NpzWriter::new();
        writer.add("x", &[6], &values).unwrap();
        writer.add("n", &[], &[4u32]).unwrap();
        let bytes = writer.finish().unwrap();
        let mut reader = NpzReader::new(&bytes).unwrap();
        assert_eq!(reader.array("n", &[]).unwrap().values, [4.0]);
        assert_eq!(reader.array("x", &[None]).unwrap().values, values);
        assert!(reader.array("x", &[Some(5)]).unwrap_err().contains("[6]"));
        assert!(reader.array("y", &[]).unwrap_err().contains("y is missing"));
    }

    #[test]
    fn damaged_arrays_are_described() {
        let bytes = npy(&[2, 3], &[0.5; 6]).unwrap();
        assert!(read_npy(&bytes[..bytes.len() - 1]).unwrap_err().contains("shorter"));
        assert!(read_npy(&[bytes.clone(), vec![0]].concat()).unwrap_err().contains("longer"));
        assert!(read_npy(b"ply\nformat").unwrap_err().contains("not a NumPy array"));
        // A stated size is not believed.
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let huge = text.replace("(2, 3)", "(9999999999, 9)").replacen("         ", "", 1);
        assert!(read_npy(huge.as_bytes()).is_err());
        assert!(NpzReader::new(&bytes).is_err());
    }
}
