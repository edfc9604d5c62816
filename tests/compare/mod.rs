//! Compare: a model beside flights, simulated ones whose answer is known and real ones, and what is gained by an extended model;
//! the page of a diagnosis, which shows both.

mod calls;
mod flights;
mod page;
mod recordings;
