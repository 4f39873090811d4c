//! One line per law: the macro declares the module, re-exports the law and enters it in the registry.

/// Declares `module::Law` pairs: `mod module; pub use module::Law;` and their registry entries.
macro_rules! register {
    ($($module:ident :: $law:ident),+ $(,)?) => {
        $(
            mod $module;
            pub use $module::$law;
        )+

        /// Every registered law, in the order of registration.
        pub const LAWS: &[Description] = &[$(<$law<f64> as LawFamily<f64>>::DESCRIPTION),+];

        /// The registered families, in the order of registration.
        pub fn families() -> Vec<LawEntry> {
            vec![$(nonsmooth_core::laws::family!($law<T>)),+]
        }

        /// The registry's entry for a law.
        ///
        /// # Errors
        /// [`LawError::UnknownLaw`] with the names that exist.
        pub fn describe(name: &str) -> Result<&'static Description, LawError> {
            LAWS.iter().find(|law| law.name == name).ok_or_else(|| LawError::UnknownLaw {
                name: name.into(),
                known: LAWS.iter().map(|law| law.name).collect::<Vec<_>>().join(", "),
            })
        }

        /// Builds a registered law from parameter values in the order of its description.
        ///
        /// # Errors
        /// [`LawError::UnknownLaw`], and those of [`LawFamily::try_new`].
        pub fn build<T: Scalar, const D: usize>(
            name: &str,
            values: &[T],
        ) -> Result<Box<dyn ContactLaw<T, D>>, LawError> {
            $(
                if name == <$law<T> as LawFamily<T>>::DESCRIPTION.name {
                    return Ok(Box::new(<$law<T> as LawFamily<T>>::try_new(values)?));
                }
            )+
            Err(describe(name).err().expect("a described law is one of those tried above"))
        }
    };
}
pub(crate) use register;
