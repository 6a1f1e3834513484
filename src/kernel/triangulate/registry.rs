//! The engines there are: the one place that lists them.

use std::ops::Deref;

use super::Engine;
use super::cuts::GreedyCuts;
use super::hitting_set::HittingSet;
use super::insertion::GreedyInsertion;

/// Makes [`EngineChoice`] of the engines' types. Each is plain data, its options, and has default ones.
macro_rules! engines {
    ($($(#[$doc:meta])* $name:ident,)+) => {
        /// The engine that triangulates tiles, and which of its variants. It can be used as the [`Engine`] that it is.
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum EngineChoice {
            $($(#[$doc])* $name($name),)+
        }

        impl EngineChoice {
            /// Every engine with its default options.
            pub fn all() -> Vec<EngineChoice> {
                vec![$(EngineChoice::$name($name::default()),)+]
            }
        }

        impl Deref for EngineChoice {
            type Target = dyn Engine;

            fn deref(&self) -> &(dyn Engine + 'static) {
                match self {
                    $(EngineChoice::$name(engine) => engine,)+
                }
            }
        }

        $(impl From<$name> for EngineChoice {
            fn from(engine: $name) -> EngineChoice {
                EngineChoice::$name(engine)
            }
        })+
    };
}

engines! {
    /// Eats the ground from its rim inward, triangle by triangle.
    GreedyCuts,
    /// Inserts the farthest sample, again and again.
    GreedyInsertion,
    /// Covers the samples with squares that a plane fits, and joins them.
    HittingSet,
}

impl Default for EngineChoice {
    fn default() -> Self {
        GreedyInsertion::default().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn engines_differ_in_name_and_identity() {
        let all = EngineChoice::all();
        for (i, engine) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|other| other.name() != engine.name()), "{}", engine.name());
            assert!(all[..i].iter().all(|other| other.identity() != engine.identity()), "{}", engine.identity());
            assert!(engine.bytes_per_sample() >= 40);
        }
        assert!(all.contains(&EngineChoice::default()));
        let (plain, improved) = (EngineChoice::from(GreedyCuts::PLAIN), EngineChoice::from(GreedyCuts::IMPROVED));
        assert_ne!(plain.identity(), improved.identity());
    }
}
