//! Which files of a crate import which, as far as names tell: what `use` brings in, and paths in the code.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::fs;
use std::path::Path;

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

/// A file's place in the tree of modules: `far/deep`.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Module(Vec<String>);

impl fmt::Display for Module {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_empty() { "the root" } else { "" })?;
        f.write_str(&self.0.join("/"))
    }
}

impl Module {
    /// The module of a file, named from `src`; none for files of tests.
    pub fn of(file: &str) -> Option<Self> {
        let mut path: Vec<String> = file.strip_suffix(".rs")?.split('/').map(str::to_owned).collect();
        match path.last()?.as_str() {
            "tests" => return None,
            "mod" | "lib" | "main" => drop(path.pop()),
            _ => {}
        }
        Some(Self(path))
    }

    fn parent(&self) -> Self {
        Self(self.0[..self.0.len().saturating_sub(1)].to_vec())
    }

    fn child(&self, name: &str) -> Self {
        Self(self.0.iter().map(String::as_str).chain([name]).map(str::to_owned).collect())
    }

    /// Whether one is above the other: they are one thing in several files, and may know each other.
    fn is_family(&self, other: &Self) -> bool {
        self.0.starts_with(&other.0) || other.0.starts_with(&self.0)
    }
}

/// A path as it is written: `crate::far::Deep`.
type Names = Vec<String>;

/// What a file says of names.
#[derive(Default)]
struct File {
    /// What `use` calls something, and its path.
    imported: BTreeMap<String, Names>,
    /// All paths.
    paths: Vec<Names>,
    /// Types it defines.
    types: Vec<String>,
}

/// The files of a crate.
pub struct Crate(BTreeMap<Module, File>);

impl Crate {
    /// Files by their names from `src`, with their text.
    pub fn of<'t>(files: impl IntoIterator<Item = (&'t str, &'t str)>) -> Self {
        Self(files.into_iter().filter_map(|(file, text)| Some((Module::of(file)?, File::parse(file, text)))).collect())
    }

    /// All files in a folder and below.
    pub fn read(src: &Path) -> Self {
        fn collect(folder: &Path, files: &mut Vec<(String, String)>, src: &Path) {
            for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
                if path.is_dir() {
                    collect(&path, files, src);
                } else if path.extension().is_some_and(|extension| extension == "rs") {
                    let name = path.strip_prefix(src).unwrap().to_str().unwrap().replace('\\', "/");
                    files.push((name, fs::read_to_string(&path).unwrap()));
                }
            }
        }
        let mut files = Vec::new();
        collect(src, &mut files, src);
        Self::of(files.iter().map(|(name, text)| (name.as_str(), text.as_str())))
    }

    pub fn files(&self) -> impl Iterator<Item = &Module> {
        self.0.keys()
    }

    /// The names of all types, and the files that define one of that name.
    pub fn types(&self) -> BTreeMap<String, Vec<String>> {
        let mut types = BTreeMap::<_, Vec<_>>::new();
        for (module, file) in &self.0 {
            file.types.iter().for_each(|name| types.entry(name.clone()).or_default().push(module.to_string()));
        }
        types
    }

    /// The files that each file imports, and a path by which it does. Modules above and below a file do not count.
    pub fn imports(&self) -> BTreeMap<Module, BTreeMap<Module, String>> {
        let mut imports = BTreeMap::<_, BTreeMap<_, _>>::new();
        for (module, file) in &self.0 {
            for path in &file.paths {
                if let Some(target) = self.resolve(module, path, 0).filter(|target| !target.is_family(module)) {
                    imports.entry(module.clone()).or_default().entry(target).or_insert_with(|| path.join("::"));
                }
            }
        }
        imports
    }

    /// Files that reach each other by imports, two or more together.
    pub fn circles(&self) -> BTreeSet<Vec<Module>> {
        let imports = self.imports();
        let reached = |from: &Module| {
            let mut reached = BTreeSet::new();
            let mut ahead = vec![from];
            while let Some(module) = ahead.pop() {
                let targets = imports.get(module).into_iter().flat_map(BTreeMap::keys);
                ahead.extend(targets.filter(|target| reached.insert((*target).clone())));
            }
            reached
        };
        let reached: BTreeMap<_, _> = self.files().map(|from| (from, reached(from))).collect();
        let circle = |of: &Module| reached[of].iter().filter(|other| reached[other].contains(of)).cloned().collect();
        self.files().map(circle).filter(|circle: &Vec<_>| circle.len() > 1).collect()
    }

    /// The imports between some files, a line each.
    pub fn tell(&self, files: &[Module]) -> String {
        let imports = self.imports();
        let between = files.iter().flat_map(|file| imports.get(file).into_iter().flatten().map(move |to| (file, to)));
        let lines = between.filter(|(_, (target, _))| files.contains(target));
        lines.map(|(file, (target, path))| format!("    {file} imports {target} ({path})\n")).collect()
    }

    /// The file that a path leads to from a module; none outside of the crate.
    fn resolve(&self, from: &Module, path: &[String], depth: usize) -> Option<Module> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => self.descend(Module::default(), rest, depth),
            "self" => self.descend(from.clone(), rest, depth),
            "super" => {
                let ups = path.iter().take_while(|name| *name == "super").count();
                self.descend((0..ups).fold(from.clone(), |module, _| module.parent()), &path[ups..], depth)
            }
            name if self.0.contains_key(&from.child(name)) => self.descend(from.clone(), path, depth),
            name => self.imported(from, name, rest, depth)?,
        }
    }

    /// The file in which the names below a module end.
    fn descend(&self, module: Module, names: &[String], depth: usize) -> Option<Module> {
        let Some((first, rest)) = names.split_first() else { return Some(module) };
        let child = module.child(first);
        if self.0.contains_key(&child) {
            return self.descend(child, rest, depth);
        }
        // What the module does not import is its own.
        self.imported(&module, first, rest, depth).unwrap_or(Some(module))
    }

    /// Where a name that a module imports leads, and names below it; none if it imports no such name.
    fn imported(&self, module: &Module, name: &str, rest: &[String], depth: usize) -> Option<Option<Module>> {
        /// Re-exports of re-exports end somewhere.
        const DEEPEST: usize = 16;
        let path = self.0.get(module)?.imported.get(name).filter(|_| depth < DEEPEST)?;
        Some(self.resolve(module, &[path, rest].concat(), depth + 1))
    }
}

impl File {
    fn parse(name: &str, text: &str) -> Self {
        let tokens: TokenStream = text.parse().unwrap_or_else(|error| panic!("{name} is not Rust: {error}"));
        let mut file = Self::default();
        file.take(tokens, true);
        file
    }

    /// Takes in a run of tokens, `top` being those in no braces.
    fn take(&mut self, tokens: TokenStream, top: bool) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            at += 1;
            match token {
                TokenTree::Group(group) if is_test(group) => {
                    // The item goes on to its body, or a semicolon.
                    let ends = |token: &TokenTree| is_punct(token, ';') || braces(token).is_some();
                    at += tokens[at..].iter().position(ends).map_or(tokens.len(), |end| end + 1);
                }
                TokenTree::Group(group) => self.take(group.stream(), false),
                TokenTree::Ident(word) => match word.to_string().as_str() {
                    // Followed by `<` it tells what a type captures.
                    "use" if !tokens.get(at).is_some_and(|next| is_punct(next, '<')) => {
                        let length = tokens[at..].iter().position(|token| is_punct(token, ';')).unwrap_or(0);
                        self.import(&tokens[at..at + length], &[]);
                        at += length;
                    }
                    // In braces `type` is mostly a trait's.
                    keyword @ ("struct" | "enum" | "trait" | "type") if top || keyword != "type" => {
                        if let Some(TokenTree::Ident(name)) = tokens.get(at) {
                            self.types.push(name.to_string());
                        }
                    }
                    _ => {
                        let (path, length) = path(&tokens[at - 1..]);
                        at += length - 1;
                        self.paths.extend(Some(path).filter(|path| path.len() > 1));
                    }
                },
                _ => {}
            }
        }
    }

    /// Takes in the tree of a `use`, below some names.
    fn import(&mut self, tree: &[TokenTree], above: &[String]) {
        let (mut names, length) = path(tree);
        names.splice(0..0, above.iter().cloned());
        match &tree[length..] {
            [.., group] if let Some(inner) = braces(group) => {
                let inner: Vec<TokenTree> = inner.stream().into_iter().collect();
                inner
                    .split(|token| is_punct(token, ','))
                    .filter(|part| !part.is_empty())
                    .for_each(|part| self.import(part, &names));
            }
            after => {
                // `a::{self}` is `a`.
                names.pop_if(|name| name == "self" && !above.is_empty());
                let renamed = after.last().filter(|_| after.len() == 2).map(TokenTree::to_string);
                let name = renamed.or_else(|| names.last().cloned()).unwrap_or_default();
                // A macro is exported from its file under its own name.
                if names != [name.as_str()] && !after.iter().any(|token| is_punct(token, '*')) {
                    self.imported.insert(name, names.clone());
                }
                self.paths.push(names);
            }
        }
    }
}

/// The names that a run of tokens begins with, joined by double colons, and how many tokens they are.
fn path(tokens: &[TokenTree]) -> (Names, usize) {
    let mut names = Vec::new();
    let mut at = 0;
    while let Some(TokenTree::Ident(name)) = tokens.get(at) {
        names.push(name.to_string());
        at += 1;
        match tokens.get(at..at + 2) {
            Some([first, second]) if is_punct(first, ':') && is_punct(second, ':') => at += 2,
            _ => break,
        }
    }
    (names, at)
}

fn is_punct(token: &TokenTree, wanted: char) -> bool {
    matches!(token, TokenTree::Punct(found) if found.as_char() == wanted)
}

fn braces(token: &TokenTree) -> Option<&Group> {
    match token {
        TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => Some(group),
        _ => None,
    }
}

/// Whether a group is that of `#[cfg(test)]`.
fn is_test(group: &Group) -> bool {
    let text = group.stream().to_string();
    group.delimiter() == Delimiter::Bracket && text.split_whitespace().collect::<String>() == "cfg(test)"
}
